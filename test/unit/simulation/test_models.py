"""Models by name: their states, relative to one another, and how states are set."""
import math

import numpy as np
import pybullet
import pytest

from img_recog.formats import model_file
from img_recog.report import Report
from img_recog.simulation.models import Models, State
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog_helpers import sdf
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, burgers

ROBOT = 'turtlebot3_burger'
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
LEFT = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))       # a quarter turn
REST = (0.0, 0.0, 0.0)
GOOD = State(REST, UPRIGHT, REST, REST)
NAN, INF = float('nan'), float('inf')
QUIET = burgers('imu', gyro_noise=0.0, accel_noise=0.0)


def close(value):
    return pytest.approx(np.array(value), abs=1e-6)


def with_crates(*crates, static=False, **settings):
    """Return a simulator of the burger and crates: a name and a pose each."""
    return assemble(sdf.sdf(sdf.BUILT_IN, *(
        sdf.body(name, pose, sdf.box(0.2, 0.2, 0.2), static, mass=2, moments=0.02)
        for name, pose in crates)), **settings)


def readings(sim, sensor, steps):
    return [each.value for each in sim.advance(steps) if each.sensor == sensor]


def test_names_are_those_of_floor_world_and_robot():
    assert Models(assemble('turtlebot3_world')).names == [
        'ground_plane', 'turtlebot3_world', ROBOT]
    assert Models(assemble()).names == ['ground_plane', ROBOT]
    # of equal names, the first stays, and a robot gets another one
    models = Models(with_crates(*[('a', '{} 0 1 0 0 0'.format(x)) for x in range(3)],
                                (ROBOT, '5 0 1 0 0 0')))
    assert models.names == ['ground_plane', 'a', ROBOT, ROBOT + '_0']
    assert models.state('a').position[0] == close(0)


def test_models_of_files_are_found_by_any_name():
    given = ['a', 'a::l', 'a::b::c', ' ', '', 'a/b']
    models = Models(with_crates(*[
        (name, '{} 0 1 0 0 0'.format(x)) for x, name in enumerate(given)]))
    assert models.names == ['ground_plane', *given, ROBOT]
    for x, name in enumerate(given):
        assert models.state(name).position == close([x, 0, 1])
        models.set_state(name, GOOD._replace(position=(x, 5.0, 1.0)))
        assert models.state(name).position == close([x, 5, 1])
    for name in given:
        models.remove(name)
    assert models.names == ['ground_plane', ROBOT]


def test_state_in_the_world():
    sim = assemble(x=1.0, y=-2.0, yaw=math.pi / 2)
    models = Models(sim)
    state = models.state(ROBOT)
    assert state.position == close([1, -2, 0]) and state.orientation == close(LEFT)
    assert state.linear == close(REST) and state.angular == close(REST)
    assert models.state('ground_plane').position == close(REST)
    assert models.state('ground_plane::link').position == close(REST)
    sim.robots[0].command(0.2, 0.0)
    sim.advance(2000)
    assert models.state(ROBOT).linear == pytest.approx([0, 0.2, 0], abs=0.01)


def test_state_seen_from_a_turned_model():
    # one that comes after "world" in the order of names
    models = Models(with_crates(('zebra', '3 1 0.1 0 0 1.5707963267948966'), x=1.0,
                                yaw=math.pi))
    models.set_state(ROBOT, State((1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.5, 0.0, 0.0),
                                  (0.0, 0.0, 0.3)))
    seen = models.state(ROBOT, 'zebra')
    # the zebra looks along the world's y: what is 1 m behind it (y) and 2 m to its left (-x)
    assert seen.position == close([-1, 2, -0.1])
    assert seen.orientation == close(LEFT)
    assert seen.linear == close([0, -0.5, 0]) and seen.angular == close([0, 0, 0.3])
    back = models.state('zebra', ROBOT)
    assert back.position == close([-2, -1, 0.1])
    assert np.abs(back.orientation) == close(LEFT) and back.orientation[2] * LEFT[3] < 0
    assert back.linear == close([0.5, 0, 0]) and back.angular == close([0, 0, -0.3])
    itself = models.state(ROBOT, ROBOT)
    assert itself.position == close(REST) and itself.linear == close(REST)


def test_set_state_in_the_world_with_a_velocity():
    sim = assemble('turtlebot3_world', x=-2.0, y=-0.5)
    sim.robots[0].command(0.2, 0.1)
    sim.advance(500)
    models = Models(sim)
    wanted = State((0.5, -0.6, 0.1), LEFT, (0.1, -0.2, 0.3), (0.4, -0.5, 0.6))
    turned = sim.robots[0].body.wheel_positions()
    models.set_state(ROBOT, wanted)
    for got, value in zip(models.state(ROBOT), wanted):
        assert got == close(value)
    motion = sim.robots[0].body.motion()
    assert motion.linear == close([-0.2, -0.1, 0.3])        # in the robot's own axes
    # wheel odometry knows nothing of being carried elsewhere
    assert min(turned) > 0.1
    assert sim.robots[0].body.wheel_positions() == close(turned)
    models.set_state(ROBOT, wanted._replace(linear=REST, angular=REST))
    assert models.state(ROBOT).linear == close(REST)
    assert models.state(ROBOT).angular == close(REST)


def test_set_state_in_the_frame_of_another_model():
    models = Models(with_crates(('crate', '3 1 0.1 0 0 1.5707963267948966')))
    models.set_state(ROBOT, State((1.0, 2.0, -0.1), LEFT, (0.5, 0.0, 0.2), (0.1, 0.0, 0.0)),
                     'crate')
    state = models.state(ROBOT)
    assert state.position == close([1, 2, 0])
    assert np.abs(state.orientation) == close([0, 0, 1, 0])
    assert state.linear == close([0, 0.5, 0.2]) and state.angular == close([0, 0.1, 0])
    models.set_state('crate', State((0.5, 0.0, 0.1), UPRIGHT, REST, REST), ROBOT)
    assert models.state('crate').position == close([0.5, 2, 0.1])


@pytest.mark.parametrize('factor', [1e-3, 0.5, -3.0, 0.0])
def test_orientation_of_any_length_is_a_rotation(factor):
    models = Models(assemble(yaw=1.0))
    long = tuple(factor * value for value in LEFT)
    models.set_state(ROBOT, State((1.0, 2.0, 0.0), long, REST, REST))
    state = models.state(ROBOT)
    # like in Gazebo, zeros are no rotation
    turn = np.multiply(np.sign(state.orientation[3]), state.orientation)
    assert turn == close(LEFT if factor else UPRIGHT) and state.position == close([1, 2, 0])


def teleported(sim, name=ROBOT):
    """Drive at 0.5 m/s and stop, while the robot is elsewhere."""
    models = Models(sim)
    sim.robots[0].command(0.5, 0.0)
    sim.advance(1000)
    sim.robots[0].command(0.0, 0.0)
    models.set_state(name, State((4.0, 5.0, 0.0), LEFT, REST, REST))
    return sim


@pytest.mark.parametrize('has_twin', [False, True])
def test_a_teleport_is_not_an_acceleration_and_changes_the_odometry(has_twin):
    # a model that is called like the robot is not it
    sim = teleported(with_crates((ROBOT, '3 0 0.1 0 0 0'), imu=QUIET)
                     if has_twin else assemble(imu=QUIET), ROBOT + '_0' * has_twin)
    first = readings(sim, 'imu', 5)[0]
    assert np.linalg.norm(np.subtract(first.linear_acceleration, [0, 0, 9.8])) < 0.5
    assert first.orientation == pytest.approx(LEFT, abs=0.01)
    odometry = readings(sim, 'odometry', 33)[0]
    assert odometry.position == pytest.approx([4, 5, 0], abs=0.02)


def test_a_teleport_turns_no_wheel():
    sim = teleported(assemble(odometry=OdometrySettings(odometry_source='encoder')))
    assert np.abs([value.linear[0] for value in readings(sim, 'odometry', 66)]).max() < 0.6


def test_static_model_is_moved_until_the_world_is_reset():
    sim = with_crates(('shelf', '3 0 0.1 0 0 0'), static=True)
    models, world = Models(sim), sim.world
    revision = world.revision
    assert ahead(sim) == close(2.9)
    models.set_state('shelf', State((2.0, 0.0, 0.1), UPRIGHT, (1.0, 0.0, 0.0), REST))
    assert world.revision == revision + 1
    sim.advance(1000)
    assert models.state('shelf') == State(*map(close, ((2.0, 0.0, 0.1), UPRIGHT, REST, REST)))
    assert ahead(sim) == close(1.9)
    models.set_state('shelf', State((2.5, 0.0, 0.1), UPRIGHT, REST, REST))
    sim.reset_world()
    assert models.state('shelf').position == close((3.0, 0.0, 0.1))
    # what was moved once is drawn where it is: nothing has to be read again
    assert ahead(sim) == close(2.9) and world.revision == revision + 1
    shelf, = world.scenery
    assert Parts(sim).moving[-len(shelf.links):] == (True,) * len(shelf.links)


def test_model_with_loose_links_is_one_model_that_moves_rigidly():
    sim = assemble(sdf.sdf(sdf.BUILT_IN, sdf.model(
        'pair', sdf.link('a', '0 1 1', sdf.ball(0.1)), sdf.link('b', '0 -1 1', sdf.ball(0.1)),
        pose='1 0 0')))
    models = Models(sim)
    assert models.names == ['ground_plane', 'pair', ROBOT]
    assert models.state('pair').position == close((1, 0, 0))
    models.set_state('pair', State((5.0, 0.0, 1.0), LEFT, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    a, b = (body.motion() for body in sim.world.scenery)
    assert a.position == close((4, 0, 2)) and b.position == close((6, 0, 2))
    assert models.state('pair').orientation == close(LEFT)
    assert models.state('pair').linear == close((1, 0, 0))
    # in their own frames, which are turned to the left; the model turns about its origin
    assert a.linear == close((-1, -1, 0)) and b.linear == close((1, -1, 0))
    models.set_state('pair::b', State((0.0, 0.0, 3.0), UPRIGHT, (1.0, 0.0, 0.0), REST), 'pair::a')
    a, b = (body.motion() for body in sim.world.scenery)
    assert a.position == close((4, 0, 2)) and b.position == close((4, 0, 5))
    assert b.linear == close((1, 0, 0))
    models.remove('pair')
    assert models.names == ['ground_plane', ROBOT] and sim.world.scenery == []


BALL = '<sdf version="1.6">{}</sdf>'.format(
    sdf.body('any', '0 0 0.5', sdf.ball(0.1), mass=2, moments=0.02))


def ahead(sim):
    """Return the distance along x from (0, 0, 0.1) to a surface, past the robot."""
    hit = pybullet.rayTest((0.3, 0, 0.1), (9, 0, 0.1),
                           physicsClientId=sim.world.physics_client_id)[0]
    return hit[3][0]


def nowhere(_):
    return None


def test_added_model_is_simulated_seen_and_removed():
    sim = assemble(yaw=0.0)
    models = Models(sim)
    ball = State((2.0, 1.0, 0.0), (0.0, 0.0, 0.0, 0.0), REST, REST)
    models.add('ball', model_file.read(BALL, 'ball', nowhere, Report()), ball)
    assert models.names == ['ground_plane', ROBOT, 'ball']
    assert models.state('ball').position == close((2, 1, 0.5))
    sim.advance(1500)
    assert models.state('ball').position == pytest.approx([2, 1, 0.1], abs=2e-3)
    models.set_state('ball', State((2.0, 0.0, 0.1), UPRIGHT, REST, REST))
    assert ahead(sim) == pytest.approx(1.9, abs=1e-3)
    sim.reset_world()
    assert models.state('ball').position == close((2, 1, 0.5))
    models.remove('ball')
    assert models.names == ['ground_plane', ROBOT] and sim.world.scenery == []
    assert ahead(sim) == 0.0        # nothing is hit
    sim.advance(100)
    assert models.state(ROBOT).position == pytest.approx([0, 0, 0], abs=0.02)


def test_added_model_stands_in_the_frame_of_another():
    models = Models(assemble(x=1.0, yaw=math.pi / 2))
    models.add('ball', model_file.read(BALL, 'ball', nowhere, Report()),
               State((1.0, 0.0, 0.0), UPRIGHT, REST, REST), ROBOT)
    assert models.state('ball').position == pytest.approx([1, 1, 0.5], abs=1e-3)
    assert models.state('ball').orientation == pytest.approx(LEFT, abs=1e-3)


@pytest.mark.parametrize('name, state, frame, words', [
    (ROBOT, GOOD, 'world', 'there is a model {} already; give another name'.format(ROBOT)),
    ('ball', GOOD._replace(position=(0.0, NAN, 0.0)), 'world', 'finite numbers'),
    ('ball', GOOD, 'map', "no model 'map' (models: ground_plane, ")])
def test_refused_model_is_not_added(name, state, frame, words):
    sim = assemble()
    models, revision = Models(sim), sim.world.revision
    ball = model_file.read(BALL, name, nowhere, Report())
    assert words in refusal(models.add, name, ball, state, frame)
    assert models.names == ['ground_plane', ROBOT] and sim.world.revision == revision
    assert sim.world.scenery == []


def test_model_that_pybullet_cannot_load_leaves_nothing(tmp_path):
    (tmp_path / 'cut.stl').write_bytes(b'solid')
    text = BALL.replace(sdf.ball(0.1), '<mesh><uri>{}</uri></mesh>'.format(tmp_path / 'cut.stl'))
    sim = assemble()
    models = Models(sim)
    bodies = pybullet.getNumBodies(physicsClientId=sim.world.physics_client_id)
    assert 'model ball: cannot read the mesh' in refusal(
        models.add, 'ball', model_file.read(text, 'ball', nowhere, Report()), GOOD)
    assert models.names == ['ground_plane', ROBOT]
    assert pybullet.getNumBodies(physicsClientId=sim.world.physics_client_id) == bodies


def test_a_robot_can_be_deleted_and_the_floor_cannot():
    sim = assemble()
    models = Models(sim)
    assert 'model ground_plane cannot be deleted' in refusal(models.remove, 'ground_plane')
    assert "no model 'r2d2' (models: ground_plane, " in refusal(models.remove, 'r2d2')
    assert models.names == ['ground_plane', ROBOT]
    assert models.remove(ROBOT).name == ROBOT
    assert models.names == ['ground_plane'] and sim.robots == [] and sim.advance(10) == []


@pytest.mark.parametrize('name, state, frame, words', [
    ('r2d2', GOOD, 'world', "no model 'r2d2' (models: ground_plane, turtlebot3_world, " + ROBOT),
    (ROBOT, GOOD, 'map', "no model 'map' (models: ground_plane, "),
    (ROBOT, GOOD._replace(position=(0.0, NAN, 0.0)), 'world', 'finite numbers'),
    (ROBOT, GOOD._replace(linear=(INF, 0.0, 0.0)), 'world', 'finite numbers'),
    (ROBOT, GOOD._replace(linear=(0.0, 1000000.5, 0.0)), 'world', 'from -1e+06 to 1e+06'),
    (ROBOT, GOOD._replace(position=(-1e300, 0.0, 0.0)), 'world', 'from -1e+06 to 1e+06'),
    (ROBOT, GOOD._replace(orientation=(0.0, 0.0, 0.0, 1e200)), 'world', 'from -1e+06 to 1e+06'),
    (ROBOT, GOOD._replace(orientation=(0.0, 0.0, NAN, 1.0)), 'world', 'finite numbers'),
    ('ground_plane', GOOD, 'world', 'model ground_plane cannot be moved'),
    (ROBOT + '::wheel_left_link', GOOD, 'world', "has no link 'wheel_left_link' without a joint "
     'above it (such links: base_footprint)')])
def test_refusals_leave_everything_where_it_is(name, state, frame, words):
    sim = assemble('turtlebot3_world', x=-2.0, y=-0.5)
    models = Models(sim)
    assert words in refusal(models.set_state, name, state, frame)
    assert models.state(ROBOT).position == close([-2, -0.5, 0])
    if words.startswith('no model'):
        assert words in refusal(models.state, name, frame)
