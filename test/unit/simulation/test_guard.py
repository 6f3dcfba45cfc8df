"""What is done with models for which the physics computes NaN, or which it throws away."""
import math

import pybullet
import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import world_file
from img_recog.simulation import assembly
from img_recog.simulation.physics import surfaces
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers import sdf
from img_recog_helpers.robots import assemble

NAN = (math.nan,) * 3
CRATES = sdf.sdf(sdf.BUILT_IN, *(sdf.CRATE.format(pose).replace('crate', name) for name, pose in (
    ('bad', '1 1 0.1 0 0 0'), ('good', '2 1 0.1 0 0 0'))))
HINGED = '''<model name="hinged"><link name="base"><pose>3 3 0.1 0 0 0</pose>{0}{1}</link>
  <link name="arm"><pose>3 3 0.5 0 0.3 0</pose>{0}</link>
  <joint name="j" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz>
  </axis></joint></model>'''.format(sdf.INERTIAL, sdf.BOX.format('collision', '', '0.4 0.4 0.2'))


class Run:
    """A robot that drives beside crates; lines: what was said."""

    def __init__(self, world=CRATES):
        self.simulator = assemble(world)
        self.lines = []
        self.simulator.world.report.listen(self.lines.append)
        self.bodies = {body.name: body for body in self.simulator.world.scenery}
        self.robot = self.simulator.robots[0].body

    def drive(self, seconds):
        """Return how far the robot gets, in m."""
        before = self.robot.pose().position[0]
        for _ in range(round(seconds * 20)):
            self.simulator.robots[0].command(0.2, 0.0)
            self.simulator.advance(50)
        for body in (self.robot, self.simulator.world.floor, *self.bodies.values()):
            assert all(map(math.isfinite, body.pose().position)), body.name
        return self.robot.pose().position[0] - before


@pytest.fixture
def run():
    """A Run that has begun."""
    found = Run()
    found.drive(0.5)
    return found


def set_velocity(body, velocity):
    pybullet.resetBaseVelocity(body.body_id, velocity, physicsClientId=body.physics_client_id)


def assert_moves(run, name):
    """A crate that is lifted falls."""
    run.bodies[name].raise_by(0.1)
    run.simulator.advance(500)
    assert run.bodies[name].pose().position[2] == pytest.approx(0.1, abs=0.01)


def test_what_brings_nan_is_frozen_and_the_rest_goes_on(monkeypatch):
    given = surfaces._scales
    monkeypatch.setattr(surfaces, '_scales', lambda body, *more: (
        list(NAN) if body.model.name == 'bad' else given(body, *more)))
    run = Run()
    assert run.drive(1.0) == pytest.approx(0.18, abs=0.02)
    assert run.lines == ['bad: the physics has thrown it to infinity; it stays where it was at 0 '
                         's; check its masses, inertias and springs, and reset the world']
    assert run.bodies['bad'].pose().position == pytest.approx((1.0, 1.0, 0.1))
    assert_moves(run, 'good')
    monkeypatch.undo()
    run.simulator.reset_world()
    run.drive(0.5)
    assert_moves(run, 'bad')


def test_after_a_reset_all_moves_as_before(run):
    def way():
        run.simulator.reset_world()
        run.drive(1.0)
        return run.robot.pose().position, run.bodies['bad'].pose().position
    before = way()
    set_velocity(run.bodies['bad'], NAN)
    run.drive(0.3)
    set_velocity(run.robot, NAN)
    run.drive(0.3)
    assert 'bad' in run.lines[0].split(':')[0] and len(run.lines) in (2, 3)
    after = way()
    assert after[0] == pytest.approx(before[0], abs=1e-4)
    assert after[1] == pytest.approx(before[1], abs=1e-4)


def test_a_reset_just_after_nan(run):
    set_velocity(run.bodies['bad'], NAN)
    for _ in range(3):
        run.simulator.world.step()
    run.simulator.reset_world()
    assert run.drive(0.5) == pytest.approx(0.08, abs=0.02) and run.lines == []
    assert_moves(run, 'bad')


def test_nan_that_does_not_come_again_freezes_nothing_at_first(run):
    set_velocity(run.bodies['bad'], NAN)
    assert run.drive(0.5) > 0.05
    assert run.lines == ['bad, good: the physics computed nan, and not again from where they were '
                         'at 0.5 s; they were moved back to there']
    assert_moves(run, 'bad')
    set_velocity(run.bodies['bad'], NAN)
    run.drive(0.2)
    # what NaN spreads to depends on the order in which the solver computes contacts
    frozen = {line.split(':')[0] for line in run.lines[1:]}
    assert 'bad' in frozen and frozen <= {'bad', 'good', 'turtlebot3_burger'}


def test_what_is_too_fast_is_frozen_before_it_is_nan(run):
    set_velocity(run.bodies['bad'], (0.0, 0.0, 1e12))
    run.drive(0.5)
    assert len(run.lines) == 1 and run.lines[0].startswith('bad: the physics has thrown it to')
    assert run.bodies['bad'].pose().position == pytest.approx((1.0, 1.0, 0.1), abs=0.01)
    assert_moves(run, 'good')


def test_the_joints_of_a_frozen_model_stay():
    run = Run(sdf.sdf(sdf.BUILT_IN, HINGED))
    run.drive(0.5)
    body = run.bodies['hinged']
    set_velocity(body, (math.nan, 0.0, 0.0))
    run.drive(0.2)
    frozen = body.frame_state('arm').frame
    run.drive(0.5)
    assert body.frame_state('arm').frame == frozen and len(run.lines) == 1
    run.simulator.reset_world()
    start = body.frame_state('arm').frame
    run.drive(0.5)
    assert body.frame_state('arm').frame != start


# an element, a text in it and what is put in its place
EXTREMES = {
    'friction of 0': ('</collision>', '<surface><friction><ode><mu>0</mu><mu2>0</mu2><fdir1>1 0 0'
                      '</fdir1></ode></friction></surface></collision>'),
    'short direction': ('</collision>', '<surface><friction><ode><mu>1</mu><mu2>0.5</mu2><fdir1>'
                        '0 0 1e-12</fdir1></ode></friction></surface></collision>'),
    'stiffness below 0': ('</collision>', '<surface><contact><ode><kp>-1</kp></ode></contact>'
                          '</surface></collision>'),
    'decay': ('<link name="l">', '<link name="l"><velocity_decay><linear>1e308</linear><angular>'
              '-1e308</angular></velocity_decay>'),
    'axis': ('<xyz>0 1 0</xyz>', '<xyz>1e308 1e308 1</xyz>'),
    'plane': ('<box><size>0.2 0.2 0.2</size></box>', '<plane><normal>0 1e308 1e308</normal>'
              '<size>1 1</size></plane>'),
    'gravity': ('<world name="default">', '<world name="default"><gravity>0 0 -1e308</gravity>')}


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('case', EXTREMES)
def test_extreme_numbers_bring_no_nan(case, monkeypatch):
    old, new = EXTREMES[case]
    text = sdf.sdf(sdf.BUILT_IN, sdf.CRATE.format('1 1 0.1 0 0 0'), HINGED)
    assert old in text
    run = Run(text.replace(old, new))
    run.drive(0.5)


def test_a_model_of_a_world_with_a_drive_is_read_without_its_encoders():
    text = sdf.sdf(HINGED.replace(
        '</model>', '<plugin filename="libgazebo_ros_joint_state_publisher.so"/><plugin '
        'filename="libgazebo_ros_diff_drive.so"><leftJoint>j</leftJoint></plugin></model>'))
    file = world_file.read('hall.world', {}, read_file=lambda path: text)
    built = assembly.build(PhysicsSettings(world='hall.world'), file, [], kinds=SENSORS)
    assert built.advance(200) == []
