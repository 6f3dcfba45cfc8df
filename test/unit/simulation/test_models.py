"""Models by name: their states, relative to one another, and how states are set."""
import math

import numpy as np
import pytest

from img_recog.simulation.models import Models, State
from img_recog.simulation.settings import ImuSettings, OdometrySettings, SimulationError
from img_recog_testing.robots import simulator

ROBOT = 'turtlebot3_burger'
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
LEFT = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))       # a quarter turn
REST = (0.0, 0.0, 0.0)
GOOD = State(REST, UPRIGHT, REST, REST)
NAN, INF = float('nan'), float('inf')
QUIET = ImuSettings(gyro_noise=0.0, accel_noise=0.0)
CRATES = '<sdf version="1.6"><world name="w">{}</world></sdf>'
CRATE = """<model name="{}"><pose>{}</pose><static>{}</static><link name="l"><inertial>
  <mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.02</iyy><izz>0.02</izz><ixy>0</ixy>
  <ixz>0</ixz><iyz>0</iyz></inertia></inertial>
  <collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
  </link></model>"""


def close(value):
    return pytest.approx(np.array(value), abs=1e-6)


def with_crates(tmp_path, *crates, static='false', **settings):
    path = tmp_path / 'crates.world'
    path.write_text(CRATES.format(''.join(CRATE.format(*crate, static) for crate in crates)))
    return simulator(str(path), **settings)


def readings(sim, sensor, steps):
    return [each.value for each in sim.advance(steps) if each.sensor == sensor]


def test_names_are_those_of_floor_world_and_robot(tmp_path):
    assert Models(simulator('turtlebot3_world')).names == [
        'ground_plane', 'turtlebot3_world', ROBOT]
    assert Models(simulator()).names == ['ground_plane', ROBOT]
    twins = with_crates(tmp_path, ('crate', '2 0 0.1 0 0 0'), ('crate', '3 0 0.1 0 0 0'))
    models = Models(twins)
    assert models.names == ['ground_plane', 'crate', 'crate_0', ROBOT]
    assert models.state('crate').position == close([2, 0, 0.1])
    assert models.state('crate_0').position == close([3, 0, 0.1])


def test_names_of_equal_models_are_numbered(tmp_path):
    models = Models(with_crates(tmp_path, *[('a', '{} 0 1 0 0 0'.format(x)) for x in range(3)]))
    assert models.names == ['ground_plane', 'a', 'a_0', 'a_1', 'turtlebot3_burger']
    assert [models.state(name).position[0] for name in ('a', 'a_0', 'a_1')] == close([0, 1, 2])


def test_state_in_the_world():
    models = Models(simulator(x=1.0, y=-2.0, yaw=math.pi / 2))
    state = models.state(ROBOT)
    assert state.position == close([1, -2, 0]) and state.orientation == close(LEFT)
    assert state.linear == close(REST) and state.angular == close(REST)
    assert models.state('ground_plane').position == close(REST)


def test_velocity_is_in_the_axes_of_the_world():
    sim = simulator(yaw=math.pi / 2)
    sim.vehicles[0].command(0.2, 0.0)
    sim.advance(2000)
    assert Models(sim).state(ROBOT).linear == pytest.approx([0, 0.2, 0], abs=0.01)


def test_state_seen_from_a_turned_model(tmp_path):
    sim = with_crates(tmp_path, ('crate', '3 1 0.1 0 0 1.5707963267948966'), x=1.0, yaw=math.pi)
    models = Models(sim)
    models.set_state(ROBOT, State((1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.5, 0.0, 0.0),
                                  (0.0, 0.0, 0.3)))
    seen = models.state(ROBOT, 'crate')
    # the crate looks along the world's y: what is 1 m behind it (y) and 2 m to its left (-x)
    assert seen.position == close([-1, 2, -0.1])
    assert seen.orientation == close(LEFT)
    assert seen.linear == close([0, -0.5, 0]) and seen.angular == close([0, 0, 0.3])
    back = models.state('crate', ROBOT)
    assert back.position == close([-2, -1, 0.1])
    assert np.abs(back.orientation) == close(LEFT) and back.orientation[2] * LEFT[3] < 0
    assert back.linear == close([0.5, 0, 0]) and back.angular == close([0, 0, -0.3])
    itself = models.state(ROBOT, ROBOT)
    assert itself.position == close(REST) and itself.linear == close(REST)


def test_state_seen_from_a_model_whose_name_comes_after_world(tmp_path):
    models = Models(with_crates(tmp_path, ('zebra', '3 1 0.1 0 0 0')))
    assert models.state(ROBOT, 'zebra').position == close([-3, -1, -0.1])


def test_set_state_in_the_world_with_a_velocity():
    sim = simulator('turtlebot3_world', x=-2.0, y=-0.5)
    sim.vehicles[0].command(0.2, 0.1)
    sim.advance(500)
    models = Models(sim)
    wanted = State((0.5, -0.6, 0.1), LEFT, (0.1, -0.2, 0.3), (0.4, -0.5, 0.6))
    turned = sim.vehicles[0].robot.wheel_positions()
    models.set_state(ROBOT, wanted)
    for got, value in zip(models.state(ROBOT), wanted):
        assert got == close(value)
    motion = sim.vehicles[0].robot.motion()
    assert motion.linear == close([-0.2, -0.1, 0.3])        # in the robot's own axes
    # wheel odometry knows nothing of being carried elsewhere
    assert min(turned) > 0.1
    assert sim.vehicles[0].robot.wheel_positions() == close(turned)
    models.set_state(ROBOT, wanted._replace(linear=REST, angular=REST))
    assert models.state(ROBOT).linear == close(REST)
    assert models.state(ROBOT).angular == close(REST)


def test_set_state_in_the_frame_of_another_model(tmp_path):
    models = Models(with_crates(tmp_path, ('crate', '3 1 0.1 0 0 1.5707963267948966')))
    models.set_state(ROBOT, State((1.0, 2.0, -0.1), LEFT, (0.5, 0.0, 0.2), (0.1, 0.0, 0.0)),
                     'crate')
    state = models.state(ROBOT)
    assert state.position == close([1, 2, 0])
    assert np.abs(state.orientation) == close([0, 0, 1, 0])
    assert state.linear == close([0, 0.5, 0.2]) and state.angular == close([0, 0.1, 0])
    models.set_state('crate', State((0.5, 0.0, 0.1), UPRIGHT, REST, REST), ROBOT)
    assert models.state('crate').position == close([0.5, 2, 0.1])


@pytest.mark.parametrize('factor', [1e-3, 0.5, -3.0])
def test_orientation_of_any_length_is_a_rotation(factor):
    models = Models(simulator())
    long = tuple(factor * value for value in LEFT)
    models.set_state(ROBOT, State((1.0, 0.0, 0.0), long, REST, REST))
    state = models.state(ROBOT)
    assert np.abs(state.orientation) == close(LEFT)
    assert state.orientation[2] * state.orientation[3] > 0
    assert state.position == close([1, 0, 0])


def test_a_teleport_is_not_an_acceleration_and_changes_the_odometry():
    sim = simulator(imu=QUIET)
    sim.vehicles[0].command(0.5, 0.0)
    sim.advance(1000)
    sim.vehicles[0].command(0.0, 0.0)
    Models(sim).set_state(ROBOT, State((4.0, 5.0, 0.0), LEFT, REST, REST))
    first = readings(sim, 'imu', 5)[0]
    assert np.linalg.norm(first.linear_acceleration - [0, 0, 9.8]) < 0.5
    assert first.orientation == pytest.approx(LEFT, abs=0.01)
    odometry = readings(sim, 'odometry', 33)[0]
    assert odometry.position == pytest.approx([4, 5, 0], abs=0.02)


def test_a_teleport_turns_no_wheel():
    sim = simulator(odometry=OdometrySettings(odometry_source='encoder'))
    sim.vehicles[0].command(0.5, 0.0)
    sim.advance(1000)
    sim.vehicles[0].command(0.0, 0.0)
    Models(sim).set_state(ROBOT, State((4.0, 5.0, 0.0), LEFT, REST, REST))
    assert np.abs([value.linear[0] for value in readings(sim, 'odometry', 66)]).max() < 0.6


def test_model_that_is_called_like_the_robot_is_not_it(tmp_path):
    sim = with_crates(tmp_path, (ROBOT, '3 0 0.1 0 0 0'), imu=QUIET)
    models = Models(sim)
    assert models.names == ['ground_plane', ROBOT, ROBOT + '_0']
    sim.vehicles[0].command(0.5, 0.0)
    sim.advance(1000)
    sim.vehicles[0].command(0.0, 0.0)
    models.set_state(ROBOT + '_0', State((1.0, 0.0, 0.0), UPRIGHT, REST, REST))
    first = readings(sim, 'imu', 5)[0]
    assert np.linalg.norm(first.linear_acceleration - [0, 0, 9.8]) < 0.5


def test_what_is_fixed_is_static_even_where_a_part_of_it_does(tmp_path):
    static = with_crates(tmp_path, ('shelf', '3 0 1 0 0 0'), static='true')
    mass = ('<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
            '</inertial>')
    (tmp_path / 'gate.urdf').write_text(
        '<robot name="gate"><link name="post">{0}</link><link name="door">{0}</link>'
        '<joint name="hinge" type="continuous"><parent link="post"/><child link="door"/>'
        '<axis xyz="0 0 1"/></joint></robot>'.format(mass))
    for sim, name in ((static, 'shelf'), (simulator(str(tmp_path / 'gate.urdf')), 'gate')):
        with pytest.raises(SimulationError) as error:
            Models(sim).set_state(name, GOOD)
        assert str(error.value) == 'model {} is static'.format(name)


@pytest.mark.parametrize('name, state, frame, words', [
    ('r2d2', GOOD, 'world', "no model 'r2d2' (models: ground_plane, turtlebot3_world, " + ROBOT),
    (ROBOT, GOOD, 'map', "no model 'map' (models: ground_plane, "),
    (ROBOT, GOOD._replace(position=(0.0, NAN, 0.0)), 'world', 'finite numbers'),
    (ROBOT, GOOD._replace(linear=(INF, 0.0, 0.0)), 'world', 'finite numbers'),
    (ROBOT, GOOD._replace(linear=(0.0, 1000000.5, 0.0)), 'world', 'from -1e+06 to 1e+06'),
    (ROBOT, GOOD._replace(position=(-1e300, 0.0, 0.0)), 'world', 'from -1e+06 to 1e+06'),
    (ROBOT, GOOD._replace(orientation=(0.0, 0.0, 0.0, 1e200)), 'world', 'from -1e+06 to 1e+06'),
    (ROBOT, GOOD._replace(orientation=(0.0, 0.0, NAN, 1.0)), 'world', 'finite numbers'),
    (ROBOT, GOOD._replace(orientation=(0.0, 0.0, 0.0, 0.0)), 'world', 'zero quaternion'),
    ('ground_plane', GOOD, 'world', 'model ground_plane is static'),
    ('turtlebot3_world', GOOD, 'world', 'model turtlebot3_world is static')])
def test_refusals_leave_everything_where_it_is(name, state, frame, words):
    sim = simulator('turtlebot3_world', x=-2.0, y=-0.5)
    models = Models(sim)
    with pytest.raises(SimulationError) as error:
        models.set_state(name, state, frame)
    assert words in str(error.value) and '\n' not in str(error.value)
    assert models.state(ROBOT).position == close([-2, -0.5, 0])


@pytest.mark.parametrize('name, frame', [('r2d2', 'world'), (ROBOT, 'map')])
def test_state_refuses_what_is_not_there(name, frame):
    with pytest.raises(SimulationError, match='no model .*models: ground_plane, ' + ROBOT):
        Models(simulator()).state(name, frame)
