"""The burger on PyBullet: how it stands, drives, turns, and that it does so the same each time."""
import math

import numpy as np
import pybullet
import pytest

from img_recog.simulation.sensors.joint_states import JointStateSettings
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, burgers, burgers_drive

SENSORS = ('odometry', 'joint_states', 'imu', 'scan')


def test_stands_still():
    sim = assemble()
    sim.advance(1000)
    before = sim.robots[0].body.motion()
    sim.advance(6000)
    after = sim.robots[0].body.motion()
    # not 1 mm and 0.1 degrees in a minute
    assert np.linalg.norm(after.position - before.position) < 0.001 / 10
    assert abs(after.yaw - before.yaw) < math.radians(0.1 / 10)


@pytest.mark.parametrize('yaw, speed', [(0.0, 0.22), (2.0, 0.22), (math.pi / 2, -0.22)])
def test_drives_straight_and_its_wheels_turn_as_far(yaw, speed):
    sim = assemble(yaw=yaw)
    robot = sim.robots[0].body
    sim.robots[0].command(speed, 0.0)
    sim.advance(1000)
    before, turned = robot.motion(), robot.wheel_positions()
    sim.advance(4000)
    motion, states = robot.motion(), robot.joint_states()
    way = (motion.position - before.position)[:2]
    assert way @ [math.cos(yaw), math.sin(yaw)] == pytest.approx(4 * speed, rel=0.02)
    assert abs(way @ [-math.sin(yaw), math.cos(yaw)]) < 0.002
    assert before.position[2] == pytest.approx(0.0, abs=0.001)
    # the twist is in the robot's own frame
    assert motion.linear[0] == pytest.approx(speed, rel=0.02) and abs(motion.linear[1]) < 0.005
    assert states.names == ('wheel_right_joint', 'wheel_left_joint')
    assert states.velocities == pytest.approx([speed / 0.033] * 2, rel=0.01)
    assert np.subtract(states.positions, turned) == pytest.approx(
        [4 * speed / 0.033] * 2, rel=0.02)


def test_at_the_speed_of_the_article_it_stays_on_its_wheels():
    # the command is 10 m/s: its wheels turn with more than 300 rad/s
    sim = assemble()
    sim.robots[0].command(10.0, 0.0)
    for second in range(1, 12):
        sim.advance(1000)
        motion = sim.robots[0].body.motion()
        assert abs(motion.position[2]) < 0.002
        velocities = sim.robots[0].body.joint_states().velocities
        assert velocities == pytest.approx([min(second, 10) / 0.033] * 2, rel=0.02)
    assert np.linalg.norm(motion.linear) > 4


def test_sensors_observe_at_their_periods():
    sim = assemble(odometry=OdometrySettings(odometry_period_s=0.01),
                   joint_states=JointStateSettings(joint_states_period_s=0.025))
    readings = sim.advance(100)
    times = {name: [round(each.time_s, 6) for each in readings if each.sensor == name]
             for name in ('odometry', 'joint_states')}
    assert times['odometry'] == [round(0.01 * n, 6) for n in range(1, 11)]
    assert times['joint_states'] == [0.025, 0.05, 0.075, 0.1]


def drive_with(switches, cut=10):
    """Drive with sensors enabled or disabled before each quarter, in pieces of `cut` steps.

    Returns the motion after each piece, to the bit, and the readings.
    """
    sim = assemble('turtlebot3_world', x=-2.0, y=-0.5)
    robot, places, readings = sim.robots[0], [], []
    for quarter, command in enumerate(((0.2, 0.0), (10.0, 0.4), (-10.0, 0.0), (0.0, 2.0))):
        robot.command(*command)
        for sensor, on in switches.get(quarter, {}).items():
            robot.mounted.set_enabled(sensor, on)
        for _ in range(500 // cut):
            readings.extend(sim.advance(cut))
            motion = robot.body.motion()
            places.append((motion.position.tobytes(), motion.orientation,
                           motion.linear.tobytes(), motion.angular.tobytes()))
    return places, readings


@pytest.fixture(scope='module')
def usual():
    """Poses and readings of a drive whose sensors are always enabled."""
    return drive_with({})


def seen_by(sensor, readings):
    return [(each.time_s, each.value) for each in readings if each.sensor == sensor]


def test_same_commands_same_trajectory_to_the_last_bit(usual):
    assert drive_with({})[0] == usual[0]
    assert drive_with({}, 250)[0] == usual[0][24::25]


def test_disabled_sensors_read_nothing_and_change_nothing(usual):
    places, readings = usual
    assert [len(seen_by(name, readings)) for name in SENSORS] == [60, 60, 400, 10]
    # also their noise; to enable one again has no effect
    for off, on in ((SENSORS, {}), (['imu'], {}), (['scan'], {}), ([], {'imu': True})):
        others, left = drive_with({0: dict.fromkeys(off, False), 2: on})
        assert others == places
        assert repr(left) == repr([each for each in readings if each.sensor not in off])
    others, fewer = drive_with({1: {'imu': False, 'scan': False}, 3: {'imu': True, 'scan': True}})
    assert others == places
    assert [len(seen_by(name, fewer)) for name in SENSORS] == [60, 60, 200, 5]
    assert [time_s for time_s, _ in seen_by('scan', fewer)] == pytest.approx(
        [0.2, 0.4, 1.6, 1.8, 2.0])


@pytest.mark.parametrize('quarter', [0, 1])
def test_noise_of_a_reading_does_not_depend_on_when_the_sensor_was_enabled(quarter, usual):
    late = drive_with({quarter: {'imu': False, 'scan': False}, 2: {'imu': True, 'scan': True}})[1]
    # the first acceleration is that of the robot at rest
    for sensor, first in (('scan', 5), ('imu', 201)):
        expected = seen_by(sensor, usual[1])[first:]
        assert repr(seen_by(sensor, late)[-len(expected):]) == repr(expected)


def test_imu_that_is_enabled_again_measures_no_acceleration_of_what_it_missed():
    sim = assemble()
    sim.advance(1000)
    sim.robots[0].mounted.set_enabled('imu', False)
    sim.robots[0].command(0.5, 0.0)
    sim.advance(1000)
    assert sim.robots[0].body.motion().linear[0] > 0.4
    sim.robots[0].mounted.set_enabled('imu', True)
    values = [value for _, value in seen_by('imu', sim.advance(20))]
    assert len(values) == 4
    assert np.abs([value.linear_acceleration[0] for value in values]).max() < 1.0


@pytest.mark.parametrize('settings, words', [
    ({'drive': burgers_drive(drive_period_s=0.0105)}, 'drive_period_s: got 0.0105'),
    ({'odometry': OdometrySettings(odometry_period_s=0.0335)}, 'set 0.033 or 0.034'),
    ({'odometry': OdometrySettings(odometry_period_s=0.0004)}, 'set 0.001'),
    *(({'scan': burgers('scan', scan_range_min=nearest)},
       ': scan_range_min: got {:g} m, expected less than scan_range_max, 3.5 m'.format(nearest))
      for nearest in (3.5, 4.0)),
    ({'world_name': 'mars'}, "world: got 'mars'")])
def test_refusals(settings, words):
    assert words in refusal(assemble, **settings)


def test_what_touches_the_robot_from_the_side_is_named():
    sim = assemble('turtlebot3_world', x=-2.0, y=-0.5)
    robot = sim.robots[0].body
    sim.advance(100)
    assert sim.touched(robot) == []         # it stands on the floor
    sim.robots[0].command(-0.5, 0.0)
    sim.advance(2000)
    assert sim.touched(robot) == ['turtlebot3_world']
    sim.close()
    with pytest.raises(pybullet.error):
        sim.advance(1)
