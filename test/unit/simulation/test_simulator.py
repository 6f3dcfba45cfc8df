"""The burger on PyBullet: how it stands, drives, turns, and that it does so the same each time."""
import math

import numpy as np
import pytest

from img_recog.simulation.sensors.imu import ImuSettings
from img_recog.simulation.sensors.joint_states import JointStateSettings
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.settings import DriveSettings, SimulationError, whole_steps
from img_recog_testing.robots import burger, simulator

SENSORS = ('odometry', 'joint_states', 'imu', 'scan')


def yaw_of(motion):
    x, y, z, w = motion.orientation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def test_mass_is_the_burgers():
    assert simulator().vehicles[0].robot.mass() == pytest.approx(1.0017329, abs=1e-6)


def test_stands_still_for_a_minute():
    sim = simulator()
    sim.advance(1000)
    before = sim.vehicles[0].robot.motion()
    sim.advance(60000)
    after = sim.vehicles[0].robot.motion()
    assert np.linalg.norm(after.position - before.position) < 0.001
    assert abs(yaw_of(after) - yaw_of(before)) < math.radians(0.1)


@pytest.mark.parametrize('yaw', [0.0, 2.0])
def test_drives_straight(yaw):
    sim = simulator(yaw=yaw)
    sim.vehicles[0].command(0.22, 0.0)
    sim.advance(1000)
    before = sim.vehicles[0].robot.motion()
    sim.advance(22727)
    along, across = before.position, sim.vehicles[0].robot.motion().position - before.position
    heading = np.array([math.cos(yaw), math.sin(yaw)])
    forward = across[:2] @ heading
    sideways = across[:2] @ np.array([-heading[1], heading[0]])
    assert forward == pytest.approx(5.0, rel=0.02)
    assert abs(sideways) < 0.02
    assert sim.vehicles[0].robot.motion().linear[0] == pytest.approx(0.22, rel=0.02)
    assert along[2] == pytest.approx(0.0, abs=0.001)


def test_backward_is_negative():
    sim = simulator()
    sim.vehicles[0].command(-0.22, 0.0)
    sim.advance(2000)
    assert sim.vehicles[0].robot.motion().linear[0] == pytest.approx(-0.22, rel=0.02)
    assert sim.vehicles[0].robot.motion().position[0] < -0.3


def test_turns_in_place_to_the_left():
    sim = simulator()
    sim.vehicles[0].command(0.0, 1.0)
    sim.advance(1000)
    start, turned = sim.vehicles[0].robot.motion(), 0.0
    last = yaw_of(start)
    for _ in range(200):
        sim.advance(100)
        turned += math.remainder(yaw_of(sim.vehicles[0].robot.motion()) - last, 2 * math.pi)
        last = yaw_of(sim.vehicles[0].robot.motion())
    assert turned == pytest.approx(20.0, rel=0.03)
    assert np.linalg.norm(sim.vehicles[0].robot.motion().position - start.position) < 0.03


def test_acceleration_from_rest_is_that_of_the_plugin():
    sim = simulator()
    sim.advance(500)
    sim.vehicles[0].command(10.0, 0.0)
    sim.advance(500)
    assert 0.4 < sim.vehicles[0].robot.motion().linear[0] < 0.55


def test_forward_and_back_with_slipping_wheels_keeps_the_heading():
    # the demo: full speed ahead and back, where the tyres slide
    sim = simulator()
    for speed in (10.0, 0.0, -10.0, 0.0):
        sim.vehicles[0].command(speed, 0.0)
        sim.advance(2000)
    assert abs(yaw_of(sim.vehicles[0].robot.motion())) < 0.2


def test_at_the_speed_of_the_article_it_stays_on_its_wheels():
    # the command is 10 m/s: its wheels turn with more than 300 rad/s
    sim = simulator()
    sim.vehicles[0].command(10.0, 0.0)
    for second in range(1, 13):
        sim.advance(1000)
        motion = sim.vehicles[0].robot.motion()
        assert abs(motion.position[2]) < 0.002
        velocities = sim.vehicles[0].robot.joint_states().velocities
        assert velocities == pytest.approx([min(second, 10) / 0.033] * 2, rel=0.02)
    assert np.linalg.norm(motion.linear) > 4


def test_twist_is_in_the_robots_own_frame():
    sim = simulator(yaw=math.pi / 2)
    sim.vehicles[0].command(0.2, 0.0)
    sim.advance(2000)
    motion = sim.vehicles[0].robot.motion()
    assert motion.position[1] > 0.3 and abs(motion.position[0]) < 0.01
    assert motion.linear[0] == pytest.approx(0.2, rel=0.02)
    assert abs(motion.linear[1]) < 0.005


def test_wheels_turn_as_far_as_the_robot_drives():
    sim = simulator()
    sim.vehicles[0].command(0.2, 0.0)
    sim.advance(5000)
    states = sim.vehicles[0].robot.joint_states()
    assert states.names == ('wheel_left_joint', 'wheel_right_joint')
    assert states.velocities == pytest.approx([0.2 / 0.033] * 2, rel=0.01)
    driven = sim.vehicles[0].robot.motion().position[0]
    assert states.positions == pytest.approx([driven / 0.033] * 2, rel=0.02)


def test_starts_where_it_is_put():
    motion = simulator(x=1.0, y=-2.0, yaw=0.5).vehicles[0].robot.motion()
    assert motion.position == pytest.approx([1.0, -2.0, 0.0], abs=1e-6)
    assert yaw_of(motion) == pytest.approx(0.5, abs=1e-6)


def test_a_wall_stops_it():
    sim = simulator('turtlebot3_world', x=2.0, y=-0.5)
    sim.vehicles[0].command(0.22, 0.0)
    sim.advance(8000)
    # the inner side of the wall is at x 2.644 for y -0.5, the robot's nose 0.04 m before its root
    assert 2.3 < sim.vehicles[0].robot.motion().position[0] < 2.644


def test_sensors_observe_at_their_periods():
    sim = simulator(odometry=OdometrySettings(odometry_period_s=0.01),
                    joint_states=JointStateSettings(joint_states_period_s=0.025))
    readings = sim.advance(100)
    times = {name: [round(each.time_s, 6) for each in readings if each.sensor == name]
             for name in ('odometry', 'joint_states')}
    assert times['odometry'] == [round(0.01 * n, 6) for n in range(1, 11)]
    assert times['joint_states'] == [0.025, 0.05, 0.075, 0.1]


def trajectory(cut):
    """Drive the same commands in pieces of `cut` steps and return every reading's bytes."""
    sim, seen = simulator('turtlebot3_world', x=-2.0, y=-0.5), []
    for linear, angular in ((0.2, 0.0), (10.0, 0.4), (-10.0, 0.0), (0.0, 2.0)):
        sim.vehicles[0].command(linear, angular)
        for _ in range(1200 // cut):
            for reading in sim.advance(cut):
                if reading.sensor == 'odometry':
                    seen.append((reading.value.position.tobytes(), reading.value.orientation,
                                 reading.value.linear.tobytes()))
    return seen


def test_same_commands_same_trajectory_to_the_last_bit():
    first = trajectory(10)
    assert len(first) == 145
    assert trajectory(10) == first
    assert trajectory(400) == first


def drive_with(switches):
    """Drive with sensors enabled or disabled before each quarter; return poses and readings."""
    sim = simulator('turtlebot3_world', x=-2.0, y=-0.5)
    vehicle, places, readings = sim.vehicles[0], [], []
    for quarter, command in enumerate(((0.2, 0.0), (10.0, 0.4), (-10.0, 0.0), (0.0, 2.0))):
        vehicle.command(*command)
        for sensor, on in switches.get(quarter, {}).items():
            vehicle.set_sensor_enabled(sensor, on)
        for _ in range(100):
            readings.extend(sim.advance(10))
            motion = vehicle.robot.motion()
            places.append((motion.position.tobytes(), motion.orientation,
                           motion.linear.tobytes(), motion.angular.tobytes()))
    return places, readings


def seen_by(sensor, readings):
    return [(each.time_s, each.value) for each in readings if each.sensor == sensor]


def test_disabled_sensors_read_nothing_and_change_nothing():
    places, readings = drive_with({})
    assert [len(seen_by(name, readings)) for name in SENSORS] == [121, 121, 800, 20]
    for off in ({name: False for name in SENSORS}, {'imu': False}, {'scan': False}):
        others, fewer = drive_with({0: off})
        assert others == places
        assert {each.sensor for each in fewer} == set(SENSORS) - set(off)
    others, fewer = drive_with({1: {'imu': False, 'scan': False}, 3: {'imu': True, 'scan': True}})
    assert others == places
    assert [len(seen_by(name, fewer)) for name in SENSORS] == [121, 121, 400, 10]
    assert [time_s for time_s, _ in seen_by('scan', fewer)] == pytest.approx(
        [0.2, 0.4, 0.6, 0.8, 1.0, 3.2, 3.4, 3.6, 3.8, 4.0])


def test_noise_of_the_scan_does_not_depend_on_the_imu():
    scans = [[value.tolist() for _, value in seen_by('scan', drive_with(off)[1])]
             for off in ({}, {0: {'imu': False}})]
    assert scans[0] == scans[1] and len(scans[0]) == 20
    forces = [[list(value.linear_acceleration)
               for _, value in seen_by('imu', drive_with(off)[1])]
              for off in ({}, {0: {'scan': False}})]
    assert forces[0] == forces[1] and len(forces[0]) == 800


def test_imu_that_is_enabled_again_measures_no_acceleration_of_what_it_missed():
    sim = simulator()
    sim.advance(1000)
    sim.vehicles[0].set_sensor_enabled('imu', False)
    sim.vehicles[0].command(0.5, 0.0)
    sim.advance(1000)
    assert sim.vehicles[0].robot.motion().linear[0] > 0.4
    sim.vehicles[0].set_sensor_enabled('imu', True)
    values = [value for _, value in seen_by('imu', sim.advance(20))]
    assert len(values) == 4
    assert np.abs([value.linear_acceleration[0] for value in values]).max() < 1.0


def test_enabling_an_enabled_sensor_changes_nothing():
    quarters = {quarter: {'imu': True} for quarter in range(4)}
    forces = [[list(value.linear_acceleration)
               for _, value in seen_by('imu', drive_with(switches)[1])]
              for switches in ({}, quarters)]
    assert forces[0] == forces[1]


def test_whole_steps():
    assert whole_steps('p', 0.033, 0.001) == 33
    assert whole_steps('p', 0.1, 0.001) == 100
    for period in (0.0335, 0.0004):
        with pytest.raises(SimulationError, match='does not divide'):
            whole_steps('p', period, 0.001)


@pytest.mark.parametrize('settings, words', [
    ({'drive': DriveSettings(left_joint='axle')}, 'no movable joint axle'),
    ({'drive': DriveSettings(left_joint='wheel_right_joint')}, 'the same as right_joint'),
    ({'drive': DriveSettings(drive_period_s=0.0105)}, 'drive_period_s: got 0.0105'),
    ({'odometry': OdometrySettings(odometry_period_s=0.0335)}, '0.033 or 0.034'),
    ({'world_name': 'mars'}, "world: got 'mars'"),
])
def test_refusals(settings, words):
    with pytest.raises(SimulationError) as error:
        simulator(**settings)
    assert words in str(error.value) and '\n' not in str(error.value)


def test_runs_without_the_sensors_that_it_has_no_links_for():
    urdf = burger().replace('imu_link', 'a_link').replace('base_scan', 'b_link')
    sim = simulator(urdf=urdf)
    assert sim.vehicles[0].missing_sensors == {'imu': 'imu_link', 'scan': 'base_scan'}
    assert {each.sensor for each in sim.advance(400)} == {'odometry', 'joint_states'}
    sim.vehicles[0].set_sensor_enabled('imu', True)
    asked = simulator(urdf=urdf, imu=ImuSettings(imu_frame='a_link')).vehicles[0]
    assert asked.missing_sensors == {'scan': 'base_scan'}


@pytest.mark.parametrize('x, y, z, found', [
    (-2.0, -0.5, 0.0, []), (0.0, 0.1, 0.0, ['turtlebot3_burger in turtlebot3_world']),
    (-2.0, -0.5, -0.1, ['turtlebot3_burger in ground_plane'])])
def test_a_start_inside_of_something_is_noticed(x, y, z, found):
    assert simulator('turtlebot3_world', x=x, y=y, z=z).overlaps() == found
