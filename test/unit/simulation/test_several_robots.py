"""Several robots in one world: each as if alone, until they touch."""
import math

import numpy as np
import pybullet
import pytest

from img_recog.report import Report
from img_recog.simulation import assembly
from img_recog_helpers import sdf
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import build, burger, burgers, read
from img_recog_helpers.robots import settings_of as settings

COMMANDS = ((0.2, 0.0), (10.0, 0.4), (-10.0, 0.0), (0.0, 2.0))
PLACES = ((-2.0, -0.5, 0.0), (0.5, 0.55, 1.0), (-0.5, -1.6, 2.0), (1.6, 0.55, -1.0),
          (0.55, -0.55, 3.0))


def spec(name, *place, urdf=None, has_place=True, **groups):
    return read(urdf or burger(), name).renamed(name)._replace(
        settings=settings(*place, **groups), has_place=has_place)


def several(places, world='turtlebot3_world', **groups):
    """Return the simulator of robots tb3_0, tb3_1 and so on at places (x, y, yaw)."""
    robots = [spec('tb3_{}'.format(number), *place, **groups)
              for number, place in enumerate(places)]
    return build(world, robots)


def drive(sim, numbers):
    """Drive robots, each another order of COMMANDS; return all that is measured, by robot."""
    measured = {robot.body.name: [] for robot in sim.robots}
    for turn in range(len(COMMANDS)):
        for robot, number in zip(sim.robots, numbers):
            linear, angular = COMMANDS[(turn + number) % len(COMMANDS)]
            robot.command(linear / 20, angular)
        for reading in sim.advance(300):
            if reading.sensor == 'odometry':
                value = (reading.value.position.tobytes(), reading.value.orientation,
                         reading.value.linear.tobytes(), reading.value.angular.tobytes())
            elif reading.sensor == 'imu':
                value = reading.value
            elif reading.sensor == 'joint_states':
                value = tuple(reading.value.positions), tuple(reading.value.velocities)
            else:
                continue        # a scan shows the other robots
            measured[reading.robot].append((reading.time_s, reading.sensor, value))
    return measured


@pytest.mark.parametrize('world, places', [
    ('empty', PLACES[:2]), ('turtlebot3_world', PLACES[2:])])
def test_a_robot_among_others_moves_to_the_bit_as_it_does_alone(world, places):
    measured = drive(several(places, world), range(len(places)))
    for number, place in enumerate(places):
        alone = drive(several([place], world), [number])
        assert len(alone['tb3_0']) > 300
        assert measured['tb3_{}'.format(number)] == alone['tb3_0']


def scans(sim):
    return {each.robot: each.value for each in sim.advance(200) if each.sensor == 'scan'}


def at(ranges, degrees):
    return ranges[round(degrees) % 360]


@pytest.mark.parametrize('mesh', [False, True])
def test_two_that_meet_see_each_other_in_their_scans(mesh, tmp_path):
    world = 'empty'
    if mesh:        # PyBullet casts the rays then
        (tmp_path / 'a.obj').write_text('v 9 9 9\nv 9 9 8\nv 9 8 9\nv 8 9 9\nf 1 2 3\nf 1 2 4\n'
                                        'f 1 3 4\nf 2 3 4\n')
        world = sdf.sdf(sdf.BUILT_IN, sdf.body('m', '', '<mesh><uri>{}</uri></mesh>'.format(
            tmp_path / 'a.obj'), static=True))
    exact = burgers('scan', scan_noise=0.0)
    # the scanner is 0.032 m behind the root link; it is a cylinder of radius 0.055 m, whose axis
    # is 0.015 m before the point where its rays begin
    found = scans(several([(0.0, 0.0, 0.0), (1.0, 0.0, math.pi), (0.0, 2.0, 0.0)], world,
                          scan=exact))
    assert at(found['tb3_0'], 0) == pytest.approx(0.994, abs=0.004)
    assert at(found['tb3_1'], 0) == pytest.approx(0.994, abs=0.004)
    assert at(found['tb3_0'], 90) == pytest.approx(1.947, abs=0.004)
    assert at(found['tb3_2'], -90) == pytest.approx(1.947, abs=0.004)
    assert np.isinf(at(found['tb3_0'], 180)) and np.isinf(at(found['tb3_0'], 45))


def test_scanners_of_different_numbers_of_rays_are_read_together():
    sim = several([], 'empty')
    for name, x, samples in (('a', 0.0, 360), ('b', 1.0, 720), ('c', -1.0, 360)):
        assembly.add_robot(sim, spec(name, x, 0.0, scan=burgers(
            'scan', scan_samples=samples, scan_noise=0.0)), Report())
    found = scans(sim)
    assert [len(found[name]) for name in 'abc'] == [360, 720, 360]
    assert found['a'][0] == pytest.approx(0.96, abs=0.004)
    assert found['c'][0] == pytest.approx(0.96, abs=0.004)
    assert np.isinf(found['b'][0]) and found['b'][360] == pytest.approx(0.93, abs=0.004)


def test_one_pushes_the_other():
    sim = several([(0.0, 0.0, 0.0), (0.3, 0.0, math.pi / 2)], 'empty')
    pusher, pushed = sim.robots
    pusher.command(0.2, 0.0)
    sim.advance(4000)
    assert pushed.body.motion().position[0] > 0.4
    gap = pushed.body.motion().position[0] - pusher.body.motion().position[0]
    assert 0.1 < gap < 0.3


def test_places_are_free_and_inside_of_the_walls():
    sim = several([])
    for number in range(16):
        assembly.add_robot_apart(sim, spec('tb3_{}'.format(number), -2.0, -0.5, 0.3,
                                           has_place=False), Report())
    assert sim.overlaps() == []
    found = np.array([robot.body.motion().position[:2] for robot in sim.robots])
    assert found[0] == pytest.approx([-2.0, -0.5], abs=1e-6)
    assert np.hypot(*found.T).max() < 2.7       # the radius of the wall
    between = np.hypot(*(found[:, None] - found).transpose(2, 0, 1)) + 9 * np.eye(16)
    assert between.min() >= 0.4
    assert all(robot.body.motion().yaw == pytest.approx(0.3) for robot in sim.robots)
    places = [robot.settings.spawn for robot in sim.robots]
    sim.advance(100)
    sim.reset_world()
    assert [(place.x_pos, place.y_pos) for place in places] == [
        pytest.approx(tuple(robot.body.motion().position[:2]), abs=1e-6)
        for robot in sim.robots]


def test_no_place_is_refused_and_leaves_nothing():
    walls = (sdf.link('l{}'.format(turn), '{} {} 0.5 0 0 {}'.format(
        0.6 * math.cos(turn), 0.6 * math.sin(turn), turn), sdf.box(0.1, 1.3, 1))
        for turn in np.arange(4) * math.pi / 2)
    sim = several([], sdf.sdf(sdf.BUILT_IN, sdf.model('cell', *walls, static=True)))
    assembly.add_robot_apart(sim, spec('a', 0.0, 0.0, has_place=False), Report())
    count = pybullet.getNumBodies(physicsClientId=sim.world.physics_client_id)
    refused = spec('b', 0.0, 0.0, has_place=False)
    assert refusal(assembly.add_robot_apart, sim, refused, Report()).startswith(
        'cannot use the robot in b: there is no free place for it near x 0 m, y 0 m')
    assert len(sim.robots) == 1
    assert pybullet.getNumBodies(physicsClientId=sim.world.physics_client_id) == count


def test_a_search_that_begins_in_a_wall_is_refused():
    sim = several([])
    assert 'x 0 m, y 0.1 m, where the search for a free place begins, is too near to a wall' in (
        refusal(assembly.add_robot_apart, sim, spec('a', 0.0, 0.1, has_place=False), Report()))
    assert sim.robots == []


# 0.25 m is too near to another one, beyond 1000 m is no place, and a step of 0.08 m is too high
STEP = sdf.sdf(sdf.BUILT_IN, sdf.body('step', '-1.25', sdf.box(2, 4, 0.16), static=True))


@pytest.mark.parametrize('world, start, offsets', [
    (STEP, (0.0, 0.0), [(0, 0), (0, -0.5), (0, 0.5)]),
    ('empty', (3.0, -2.0), [(0, 0), (-0.5, 0), (0, -0.5), (0, 0.5), (0.5, 0), (-0.5, -0.5),
                            (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)]),
    ('empty', (1000.0, 1000.0), [(0, 0), (-0.5, 0), (0, -0.5), (-0.5, -0.5)])])
def test_places_are_the_nearest_in_all_directions(world, start, offsets):
    sim = several([], world)
    for number in range(len(offsets)):
        assembly.add_robot_apart(sim, spec(str(number), *start, has_place=False), Report())
    spawns = [each.settings.spawn for each in sim.robots]
    assert [(each.x_pos - start[0], each.y_pos - start[1]) for each in spawns] == offsets


@pytest.mark.parametrize('place, other', [((-2.0, -0.45), 'a'), ((0.0, 0.1), 'turtlebot3_world')])
def test_a_given_place_inside_of_something_is_refused(place, other):
    sim = several([])
    assembly.add_robot_apart(sim, spec('a', -2.0, -0.5), Report())
    assert 'would start inside of ' + other in refusal(
        assembly.add_robot_apart, sim, spec('b', *place), Report())
    assert [robot.body.name for robot in sim.robots] == ['a']


def test_a_robot_that_fails_leaves_nothing():
    sim = several([PLACES[0]])
    count, revision = pybullet.getNumBodies(
        physicsClientId=sim.world.physics_client_id), sim.world.revision
    for urdf, nearest in ((burger('').replace('wheel_left_joint', 'axle'), 0.1), (burger(), 4.0)):
        robot = spec('b', 1.0, 1.0, urdf=urdf, scan=burgers('scan', scan_range_min=nearest))
        assert refusal(assembly.add_robot, sim, robot, Report()).startswith(
            'cannot use the robot in b: ')
    assert pybullet.getNumBodies(physicsClientId=sim.world.physics_client_id) == count
    assert len(sim.robots) == 1 and sim.world.revision == revision


def test_a_robot_that_is_removed_is_gone_and_the_others_go_on():
    sim = several([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], 'empty')
    first, second = sim.robots
    second.command(0.2, 0.0)
    sim.advance(1000)
    revision = sim.world.revision
    sim.world.remove(first)
    assert sim.world.revision > revision and sim.robots == [second]
    readings = sim.advance(1000)
    assert {each.robot for each in readings} == {'tb3_1'}
    assert second.body.motion().position[0] > 1.3
    behind = [each.value for each in readings if each.sensor == 'scan'][-1][180]
    assert np.isinf(behind)


def test_the_scan_shows_a_robot_that_replaced_another_with_the_same_id():
    sim = several([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], 'empty',
                  scan=burgers('scan', scan_noise=0.0))
    before = scans(sim)['tb3_0'][0]
    old, revision = sim.robots[1].body.body_id, sim.world.revision
    sim.world.remove(sim.robots[1])
    without_scanner = burger().replace('radius="0.055"', 'radius="0.01"')
    assembly.add_robot(sim, spec('tb3_1', 1.0, 0.0, urdf=without_scanner), Report())
    assert sim.robots[1].body.body_id == old and sim.world.revision == revision + 2
    assert scans(sim)['tb3_0'][0] == pytest.approx(before + 0.045, abs=0.003)


def test_a_world_without_robots_runs_and_takes_one_later():
    sim = several([], 'empty')
    assert sim.advance(50) == [] and sim.time_s == pytest.approx(0.05)
    assembly.add_robot(sim, spec('late', 0.0, 0.0), Report())
    times = [each.time_s for each in sim.advance(50) if each.sensor == 'odometry']
    assert times == pytest.approx([0.066, 0.099])
