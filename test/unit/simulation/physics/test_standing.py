"""Robots that are put into the floor, or into what lies on it, stand on that."""
import numpy as np
import pybullet
import pytest

from img_recog.report import Report
from img_recog.simulation import assembly
from img_recog.simulation.models import Models, State
from img_recog.simulation.physics import standing
from img_recog.simulation.physics.body import Body, BodyPose
from img_recog_helpers import sdf
from img_recog_helpers.robots import assemble, burger, read, settings_of

UPRIGHT, REST = (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
NAME = 'turtlebot3_burger'
AT_ITS_AXLE = burger().replace('xyz="0 0 0.010"', 'xyz="0 0 -0.023"')


@pytest.fixture
def world(tmp_path):
    """A function that returns a world with a floor of some height: a 'mesh' or a 'box'."""
    def make(kind, height):
        (tmp_path / 'sheet.obj').write_text(
            ''.join('v {0} {1} {2}\n'.format(x, y, height)
                    for x in (-2, 2) for y in (-2, 2)) + 'f 1 3 4\nf 1 4 2\n')
        pose, geometry = {
            'mesh': ('', '<mesh><uri>{}</uri></mesh>'.format(tmp_path / 'sheet.obj')),
            'box': ('0 0 {}'.format(height - 0.25), sdf.box(4, 4, 0.5))}[kind]
        return sdf.sdf(sdf.BUILT_IN, sdf.body('hall', pose, geometry, static=True))
    return make


def heights(sim, steps=1000):
    """Return the height of the root link of the robot after each 10 steps."""
    found = []
    for _ in range(steps // 10):
        sim.advance(10)
        found.append(sim.robots[0].body.motion().position[2])
    return found


def stands(sim, height):
    """Whether the robot stands at a height, and was never thrown from there."""
    found = heights(sim)
    return np.abs(np.array(found) - height).max() < 0.002


def test_a_robot_with_its_root_at_the_axle_is_lifted_out_of_the_floor_and_drives():
    sim = assemble(urdf=AT_ITS_AXLE)
    assert sim.world.report.lines() == [
        'turtlebot3_burger: at z_pos 0 m it would be in ground_plane; it was lifted onto it by '
        '0.033 m']
    assert stands(sim, 0.033)
    sim.robots[0].command(0.2, 0.0)
    sim.advance(1000)
    start = sim.robots[0].body.motion().position
    sim.advance(2000)
    assert sim.robots[0].body.motion().position - start == pytest.approx([0.4, 0, 0], abs=0.004)


@pytest.mark.parametrize('kind', ['mesh', 'box'])
@pytest.mark.parametrize('height', [0.01, 0.025, 0.04, 0.1])
def test_a_robot_in_a_floor_above_zero_is_lifted_onto_it(world, kind, height):
    built = assemble(world(kind, height))
    assert built.world.report.lines() == [
        'turtlebot3_burger: at z_pos 0 m it would be in hall; it was lifted onto it by {:.3f} m'
        .format(height)]
    assert stands(built, height)
    assert built.touched(built.robots[0].body) == []


@pytest.mark.parametrize('z, height', [(0.4, 0.4), (0.0, 0.0), (-0.5, 0.0), (0.003, 0.003)])
def test_only_what_is_in_something_is_lifted(z, height):
    built = assemble(z=z)
    assert built.robots[0].body.motion().position[2] == pytest.approx(
        height, abs=1e-4)
    assert len(built.world.report.lines()) == (z < 0)


def test_what_is_in_a_wall_is_lifted_out_of_the_floor_alone(world):
    lifted, overlap = assemble(world('box', 0.5), z=-0.1).world.report.lines()
    assert lifted.endswith('in ground_plane; it was lifted onto it by 0.100 m')
    assert overlap.startswith('turtlebot3_burger in hall: ')


def test_it_is_lifted_again_wherever_it_is_put(world):
    sim = assemble(world('mesh', 0.04))
    robot, models = sim.robots[0], Models(sim)
    for put, height in ((sim.reset_world, 0.04),
                        (lambda: robot.move_to(5.0, 0.0, 1.0), 0.0),      # beside that floor
                        (lambda: robot.move_to(1.0, 1.0, 1.0), 0.04),
                        (lambda: models.set_state(NAME, State(REST, UPRIGHT, REST, REST)), 0.04)):
        sim.advance(100)
        put()
        assert stands(sim, height)


def test_its_velocity_is_kept_when_it_is_lifted(world):
    sim = assemble(world('mesh', 0.04))
    models = Models(sim)
    models.set_state(NAME, State(REST, UPRIGHT, (0.3, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert models.state(NAME).position[2] == pytest.approx(0.04, abs=1e-3)
    assert models.state(NAME).linear == pytest.approx([0.3, 0.0, 0.0], abs=1e-6)
    assert models.state(NAME).angular == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)


@pytest.mark.parametrize('has_place', [True, False])
def test_robots_are_added_on_a_floor_above_zero(world, has_place):
    sim = assemble(world('mesh', 0.02), 1.0, 1.0)
    place = (0.0, 0.0) if has_place else (1.0, 1.0)
    report = Report()
    assembly.add_robot_apart(sim, read(burger()).renamed('second')._replace(
        settings=settings_of(*place), has_place=has_place), report)
    warning, = report.lines()
    assert warning.startswith('second: ') and warning.endswith(' by 0.020 m')
    first, second = (robot.body.motion().position for robot in sim.robots)
    assert second[2] == pytest.approx(0.02, abs=0.001)
    assert np.hypot(*(second - first)[:2]) > 0.25
    sim.reset_world()
    assert sim.robots[1].body.motion().position == pytest.approx(second, abs=1e-6)


class Boxes:
    """Boxes in a physics client of their own, beside the origin, and a floor at 0 m."""

    X, Y = 5.0, -3.0

    def __init__(self):
        self.client = pybullet.connect(pybullet.DIRECT)
        self.floor = self._body(pybullet.createCollisionShape(
            pybullet.GEOM_PLANE, physicsClientId=self.client), (0, 0, 0), 'floor')
        self.cube = self.box('cube', 0.0, 0.2, width=0.2, mass=1.0)

    def box(self, name, bottom, top, width=2.0, mass=0.0):
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=(width / 2, width / 2, (top - bottom) / 2),
            physicsClientId=self.client)
        return self._body(shape, (self.X, self.Y, (top + bottom) / 2), name, mass)

    def _body(self, shape, place, name, mass=0.0):
        body = Body(pybullet.createMultiBody(mass, shape, basePosition=place,
                                             physicsClientId=self.client), self.client)
        body.name = name
        return body

    def lift(self, bottom, *others):
        """Lift the cube, whose lower side is at a height; return how far, and its height then."""
        self.cube.place(BodyPose((self.X, self.Y, bottom + 0.1), UPRIGHT, ()))
        lifted = standing.lift(self.cube, [self.floor], others)
        assert self.cube.pose().position[:2] == pytest.approx((self.X, self.Y))
        assert self.cube.pose().position[2] - 0.1 == pytest.approx(
            bottom + lifted.height_m, abs=1e-6)
        return lifted


@pytest.mark.parametrize('bottom, tops, height, onto', [
    (0.5, (), 0.0, ''), (0.0, (), 0.0, ''), (-0.004, (), 0.0, ''), (-0.006, (), 0.006, 'floor'),
    (-3.0, (), 3.0, 'floor'), (0.0, (0.004,), 0.0, ''), (0.0, (0.006,), 0.006, 'box 0'),
    (0.0, (0.0873,), 0.0873, 'box 0'), (0.0, (0.29,), 0.29, 'box 0'), (0.0, (0.32,), 0.0, ''),
    # out of the floor first
    (-0.03, (0.05,), 0.08, 'box 0'), (-0.03, (0.35,), 0.03, 'floor'), (-0.03, (), 0.03, 'floor'),
    (0.0, (0.02, 0.05), 0.05, 'box 1'), (0.0, (0.05, 0.02), 0.05, 'box 0'),
    (0.1, (0.02, 0.13), 0.03, 'box 1')])
def test_onto_the_floor_and_boxes(bottom, tops, height, onto):
    boxes = Boxes()
    lifted = boxes.lift(bottom, *(boxes.box('box {}'.format(number), -0.2, top)
                                  for number, top in enumerate(tops)))
    # it is above them, by less than what can be seen
    assert height <= lifted.height_m + 1e-6 and lifted.height_m < height + 2e-4
    assert lifted.onto == onto


def test_onto_a_shelf_that_is_in_the_way_above_the_floor():
    boxes = Boxes()
    others = boxes.box('box', -0.2, 0.03), boxes.box('shelf', 0.215, 0.25)
    assert boxes.lift(0.0, *others) == (pytest.approx(0.25, abs=2e-4), 'shelf')
    # there is room for it between them
    others = boxes.box('box', -0.2, 0.03), boxes.box('ceiling', 0.27, 0.9)
    assert boxes.lift(0.0, *others) == (pytest.approx(0.03, abs=2e-4), 'box')


@pytest.mark.parametrize('bottom, wanted', [
    (0.1, 0.0), (0.002, 0.0), (-0.02, 0.02), (-0.06, 0.06)])
def test_depth(bottom, wanted):
    boxes = Boxes()
    boxes.cube.place(BodyPose((boxes.X, boxes.Y, bottom + 0.1), UPRIGHT, ()))
    assert standing.depth(boxes.cube, boxes.floor) == pytest.approx(wanted, abs=1e-6)
