"""Sensors that <gazebo> tags describe: places, ranges and names, in front of a wall."""
import math

import numpy as np
import pytest

from img_recog.conversions import robot_msgs
from img_recog.conversions.sensor_table import SENSORS
from img_recog.simulation.sensors.laser_scanner import LaserScanner, ScanSettings
from img_recog.simulation.sensors.sensor import Mount
from img_recog_helpers import robots, sdf
from img_recog_helpers.refusals import refusal

# the robot's root is at x 0.5; the link of the tag is at x 0.1 of that and turned to the left
LINK = ('<link name="nose"/><joint name="nose_joint" type="fixed"><parent link="base_link"/>'
        '<child link="nose"/><origin xyz="0.1 0 0" rpy="0 0 1.5707963"/></joint>')
AHEAD = '<pose>0 0 0 0 0 -1.5707963</pose>'


def sensor(plugin, samples=1, angle=0.0, far=5.0, scan='', vertical='', pose=AHEAD,
           library='gazebo_ros_laser', rate=10, kind='ray', name='s'):
    return (
        '<gazebo reference="nose"><sensor type="{}" name="{}">{}<update_rate>{}</update_rate><ray>'
        '<scan><horizontal><samples>{}</samples><min_angle>{}</min_angle><max_angle>{}</max_angle>'
        '{}</horizontal>{}</scan><range><min>0.05</min><max>{}</max></range></ray>'
        '<plugin name="p" filename="lib{}.so">{}</plugin></sensor></gazebo>').format(
            kind, name, pose, rate, samples, -angle, angle, scan, vertical, far, library, plugin)


def built(*tags, height=1):
    wall = sdf.body('wall', '2.05 0 0.5', sdf.box(0.1, 8, height), static=True)
    urdf = robots.burger('').replace('</robot>', LINK + ''.join(tags) + '</robot>')
    robot = robots.read(urdf).changed(spawn=robots.settings_of(x=0.5).spawn,
                                      drive=robots.burgers_drive())
    return robots.build(sdf.sdf(sdf.BUILT_IN, wall), [robot])


def readings(sim, steps=100):
    return {each.sensor: each.value for each in sim.advance(steps)}


def mount_of(sim):
    robot = sim.robots[0]
    return Mount(robot.body, sim.world, np.random.RandomState(), robot.drive)


def scanner_of(sim, scan_frame='base_scan', **settings):
    return LaserScanner(mount_of(sim), ScanSettings(scan_frame=scan_frame, **settings))


def test_rays_by_pybullet_go_through_the_robot_as_far_as_by_geometry():
    sim = built()
    scanner = scanner_of(sim, scan_frame='wheel_left_link', scan_samples=90,
                         scan_angle_max=6.28319, scan_range_min=0.05, scan_range_max=4.0)
    bundle = scanner.bundle()
    without = built()
    without.robots[0].move_to(-50.0, 0.0, 0.0)
    (expected,), _ = without.world.solids.distances(bundle)
    expected[expected > 4.0] = np.inf
    assert scanner.cast(bundle) == pytest.approx(expected, abs=0.002)
    assert np.isfinite(expected).sum() > 20 and np.isinf(expected).any()


@pytest.mark.parametrize('kind', [kind for kind in SENSORS if kind.tags.frame
                                  or kind.only_in_tags], ids=lambda kind: kind.name)
def test_a_frame_that_is_no_link_is_refused_with_the_name_of_the_setting(kind):
    name = kind.name + '_frame'
    line = refusal(kind.make, mount_of(robots.assemble()), kind.settings(**{name: 'nose'}))
    assert line.startswith(name + ': the robot has no link nose')


@pytest.mark.parametrize('kind', SENSORS, ids=lambda kind: kind.name)
def test_no_sensor_has_a_period_of_zero(kind):
    name = kind.name + ('_rate' if kind.is_drawn else '_period_s')
    assert refusal(kind.settings, **{name: 0.0}).startswith(name + ': got 0.0')


def test_each_sensor_measures_from_its_link_and_pose_whatever_the_frame_is_called():
    sim = built(
        sensor('<frameName>nowhere</frameName><topicName>a</topicName>'),
        sensor('<frameName>imu_link</frameName><topicName>b</topicName>',
               pose='<pose>0 -0.3 0 0 0 -1.5707963</pose>'),
        sensor('', library='gazebo_ros_range', pose='<pose>0 0 0 0 0 -2.0943951</pose>'))
    found = readings(sim)
    # a wall at x 2, seen from x 0.6, from 0.3 m nearer, and 30 degrees to the right
    assert found['scan'] == pytest.approx([1.4], abs=0.002)
    assert found['scan_2'] == pytest.approx([1.1], abs=0.002)
    assert found['range'] == pytest.approx(1.4 / math.cos(math.pi / 6), abs=0.004)
    robot = sim.robots[0]
    assert [each.name for each in robot.spec.sensors] == ['scan', 'scan_2', 'range']
    assert [robot.settings.sensors[name].scan_frame for name in ('scan', 'scan_2')] == [
        'nowhere', 'imu_link']


def rows(count, low, high):
    return ('<vertical><samples>{}</samples><min_angle>{}</min_angle><max_angle>{}</max_angle>'
            '</vertical>').format(count, low, high)


def resolution(value):
    return '<resolution>{}</resolution>'.format(value)


def between(count):
    """Return the ranges of 8 rays to the wall, interpolated."""
    rays = 1.4 / np.cos(np.linspace(-0.7, 0.7, 8))
    return np.interp(np.linspace(0, 7, count), np.arange(8), rays)


LEFT = '<pose>0 0 0.3 0 0 0</pose>'
NEAREST = 1.4 / math.cos(math.pi / 2 - 1.5)
PITCHES = (0.1, 0.3, 0.5)


@pytest.mark.parametrize('tag, name, wanted, tolerance', [
    # a range is the nearest of all rows, and the longest if nothing is hit
    (sensor('', 5, 0.5, library='gazebo_ros_range', vertical=rows(2, 0, 1.2)), 'range', 1.4,
     0.002),
    (sensor('', 1, library='gazebo_ros_range', far=1.0), 'range', 1.0, 0.0),
    *((sensor('', 8, 0.7, scan=resolution(value)), 'scan', between(count), 0.003)
      for value, count in ((0.5, 4), (2, 16), (1, 8))),
    # one that misses counts as the longest between rays: to the left there is nothing
    (sensor('', 2, 1.5, scan=resolution(1.5), far=2.0, pose=LEFT), 'scan',
     [NEAREST, (NEAREST + 2.0) / 2, math.inf], 0.003),
    (sensor('', 1, vertical=rows(3, 0.1, 0.5)), 'scan', [1.4 / np.cos(each) for each in PITCHES],
     0.006)])
def test_what_is_measured_of_a_wall(tag, name, wanted, tolerance):
    assert readings(built(tag, height=3))[name] == pytest.approx(wanted, abs=tolerance)


def test_the_middle_of_all_rows_is_published():
    assert ScanSettings(scan_rows=3).middle(np.array([1.0, 2.0, 3.0])).tolist() == [2.0]


@pytest.mark.parametrize('by_pybullet', [False, True])
def test_more_rays_than_pybullet_casts_at_a_time(by_pybullet):
    scanner = scanner_of(
        built(height=3), scan_samples=128, scan_rows=128, scan_angle_min=-0.5,
        scan_angle_max=0.5, scan_pitch_max=0.5, scan_range_min=0.12, scan_range_max=3.5)
    ranges = scanner.cast(scanner.bundle()) if by_pybullet else scanner.read()
    # 1.532 m ahead of the scanner
    assert len(ranges) == 16384 and ranges[[0, 127, 16256, 16383]] == pytest.approx(
        1.532 / np.cos(0.5) / np.array([1, 1, np.cos(0.5), np.cos(0.5)]), abs=0.005)


def test_too_many_rays():
    assert refusal(scanner_of, built(), scan_samples=2000, scan_rows=101) == (
        'got 202000 rays, at most 200000 are simulated; give the sensor fewer samples')


def test_noise_of_sensors_of_a_kind_differs():
    tag = sensor('<gaussianNoise>0.01</gaussianNoise>', library='gazebo_ros_range')
    found = readings(built(tag, tag))
    assert 0 < abs(found['range'] - found['range_2']) < 0.1


def test_a_value_that_is_not_allowed_names_the_sensor():
    assert 'its sensor scan_2: scan_samples: got 0' in refusal(
        built, sensor(''), sensor('', samples=0))


def test_two_imus():
    unit = ('<gazebo><plugin name="i" filename="libhector_gazebo_ros_imu.so"><bodyName>{}'
            '</bodyName><topicName>{}</topicName><updateRate>100</updateRate></plugin></gazebo>'
            '<gazebo reference="nose_joint"><preserveFixedJoint>true</preserveFixedJoint>'
            '</gazebo>')
    found = readings(built(unit.format('base_link', 'a'), unit.format('nose', 'b')))
    yaws = [2 * math.atan2(found[name].orientation[2], found[name].orientation[3])
            for name in ('imu', 'imu_2')]
    assert yaws == pytest.approx([0.0, math.pi / 2], abs=0.01)
    assert found['imu_2'].linear_acceleration[2] == pytest.approx(9.8, abs=0.1)


@pytest.mark.parametrize('kept, frame', [
    ('', 'base_footprint'), ('preserveFixedJoint', 'imu_link'),
    ('disableFixedJointLumping', 'imu_link')])
def test_the_unit_of_the_official_burger_is_that_of_the_plugin(kept, frame):
    sim = built((
        '<gazebo><plugin name="i" filename="libgazebo_ros_imu.so"><bodyName>imu_link</bodyName>'
        '<frameName>imu_link</frameName><topicName>imu</topicName><gaussianNoise>0.0'
        '</gaussianNoise><updateRate>0</updateRate><imu><noise><rate><stddev>1</stddev></rate>'
        '</noise></imu></plugin></gazebo><gazebo reference="imu_joint"><{0}>true</{0}></gazebo>'
        ).format(kept or 'material'))
    sim.advance(1000)
    settings = sim.robots[0].settings.sensors['imu']
    message = robot_msgs.imu_to_msg(readings(sim)['imu'], settings, robot_msgs.stamp_of(1.0))
    assert (message.header.frame_id, settings.imu_period_s) == (frame, 0.001)
    values = [each.value for each in sim.advance(50) if each.sensor == 'imu']
    assert len(values) == 50
    # at rest, without gravity and noise
    for what in ('linear_acceleration', 'angular_velocity'):
        assert np.abs([getattr(value, what) for value in values]).max() < 2e-3
    assert not any(message.linear_acceleration_covariance)


def test_joint_states_are_those_that_the_plugin_names_without_efforts():
    plugin = ('<gazebo><plugin name="j" filename="libgazebo_ros_joint_state_publisher.so">'
              '<jointName>wheel_left_joint, nose_joint, wheel_right_joint</jointName></plugin>'
              '</gazebo>')
    sim = built(plugin)
    sim.robots[0].command(0.2, 0.5)
    states = readings(sim, 500)['joint_states']
    message = robot_msgs.joint_states_to_msg(states, None, robot_msgs.stamp_of(0.5))
    assert message.name == ['wheel_left_joint', 'wheel_right_joint'] and message.effort == []
    # it turns left
    assert 0 < message.position[0] < message.position[1]
    assert 0 < message.velocity[0] < message.velocity[1]
    # a joint that does not move has no state
    urdf = robots.burger('').replace('</robot>', LINK + plugin + '</robot>')
    assert [each.what for each in robots.read(urdf).findings] == [
        'joint nose_joint of a joint state publisher']
