"""Twists, readings of sensors and calibrations as messages: round trips and refusals."""
import math

import genpy.dynamic
import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Header

from img_recog.camera.calibration import Calibration
from img_recog.conversions import image_msgs, robot_msgs, twist_msgs
from img_recog.simulation.physics.body import Motion
from img_recog.simulation.physics.robot import JointStates
from img_recog.simulation.sensors.contact_sensor import ContactSettings, Touch
from img_recog.simulation.sensors.imu import ImuReading, ImuSettings
from img_recog.simulation.sensors.joint_states import JointStateSettings
from img_recog.simulation.sensors.laser_scanner import ScanSettings
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.sensors.range_sensor import RangeSettings
from img_recog_helpers.gazebo_messages import DEFINITIONS
from img_recog_helpers.robots import burgers

STAMP = rospy.Time(12, 34)
ODOMETRY, JOINTS = OdometrySettings(base_frame='base'), JointStateSettings()
MOTION = Motion(np.array([1.0, 2.0, 3.0]), (0.1, 0.2, 0.3, math.sqrt(0.86)),
                np.array([0.4, 0.5, 0.6]), np.array([0.7, 0.8, 0.9]))
READING = ImuReading((0.0, 0.0, 0.6, 0.8), (1.0, 2.0, 3.0), (4.0, 5.0, 6.0))


def test_twist_round_trip():
    msg = twist_msgs.to_msg(0.3, -0.4)
    assert twist_msgs.from_msg(msg) == (0.3, -0.4, 0.0)
    msg.linear.y = 0.2
    assert twist_msgs.from_msg(msg) == (0.3, -0.4, 0.2)
    assert twist_msgs.from_msg(TwistStamped(twist=msg)) == (0.3, -0.4, 0.2)
    msg.linear.x = msg.linear.y = msg.angular.z = 0.0
    assert msg == Twist()


@pytest.mark.parametrize('part', ['linear', 'angular'])
@pytest.mark.parametrize('axis', 'xyz')
@pytest.mark.parametrize('value', [float('nan'), float('inf'), -float('inf')])
def test_twist_that_is_not_finite_is_refused_by_name(part, axis, value):
    msg = Twist()
    setattr(getattr(msg, part), axis, value)
    with pytest.raises(twist_msgs.TwistError, match='{}.{}={}'.format(part, axis, value)):
        twist_msgs.from_msg(msg)
    with pytest.raises(twist_msgs.TwistError):
        twist_msgs.from_msg(TwistStamped(twist=msg))


def test_odometry():
    msg = robot_msgs.odometry_to_msg(MOTION, ODOMETRY, STAMP)
    assert (msg.header.stamp, msg.header.frame_id, msg.child_frame_id) == (STAMP, 'odom', 'base')
    # x, y and yaw are estimated, like by libgazebo_ros_diff_drive
    assert list(msg.pose.covariance) == np.diag((1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)).ravel(
        ).tolist()


def test_transform_is_the_odometrys_pose():
    odometry = robot_msgs.odometry_to_msg(MOTION, ODOMETRY, STAMP)
    msg = robot_msgs.transform_of(odometry)
    moved, turned = msg.transform.translation, msg.transform.rotation
    assert (msg.header.frame_id, msg.child_frame_id, msg.header.stamp) == ('odom', 'base', STAMP)
    assert (moved.x, moved.y, moved.z) == (1.0, 2.0, 3.0)
    assert (turned.x, turned.y, turned.z, turned.w) == MOTION.orientation
    # one that is used again equals a new one
    other = robot_msgs.transform_of(robot_msgs.odometry_to_msg(
        MOTION._replace(position=np.zeros(3)), ODOMETRY, rospy.Time(1, 0)))
    assert other != msg and robot_msgs.transform_of(odometry, other) is other
    assert other == msg


@pytest.mark.parametrize('time_s, nanoseconds', [(0.033, 33000000), (0.07, 70000000),
                                                 (33 * 3 * 0.001, 99000000), (1e6, 10 ** 15)])
def test_stamps_are_exact(time_s, nanoseconds):
    assert robot_msgs.stamp_of(time_s).to_nsec() == nanoseconds


def test_scan():
    settings = burgers('scan', scan_samples=4, scan_frame='laser')
    msg = robot_msgs.scan_to_msg(np.array([0.5, np.inf, 1.0, 3.5]), settings, STAMP)
    assert (msg.header.frame_id, msg.header.stamp) == ('laser', STAMP)
    assert (msg.angle_min, msg.angle_max, msg.angle_increment) == (0.0, 6.28319, 6.28319 / 3)
    assert (msg.range_min, msg.range_max) == (0.12, 3.5)
    assert msg.intensities == [0.0] * 4


def test_scan_of_one_ray():
    msg = robot_msgs.scan_to_msg(np.array([0.5]), burgers('scan', scan_samples=1), STAMP)
    assert (msg.angle_increment, msg.ranges) == (6.28319, [0.5])


@pytest.mark.parametrize('radiation, kind', [('ultrasound', 0), ('infrared', 1)])
def test_range(radiation, kind):
    settings = RangeSettings(range_frame='ear', range_min=0.1, range_max=2.0,
                             range_field_of_view=0.3, range_radiation=radiation)
    msg = robot_msgs.range_to_msg(0.7, settings, STAMP)
    assert (msg.header.frame_id, msg.header.stamp, msg.radiation_type) == ('ear', STAMP, kind)
    assert (msg.field_of_view, msg.min_range, msg.max_range, msg.range) == (0.3, 0.1, 2.0, 0.7)
    assert robot_msgs.range_from_msg(msg) == 0.7
    again = robot_msgs.range_to_msg(0.2, settings, rospy.Time(1, 2), msg)
    assert again is msg and (msg.range, msg.header.stamp) == (0.2, rospy.Time(1, 2))


def test_field_of_view_of_the_rays():
    settings = RangeSettings(range_field_of_view=0.0, range_angle_min=-0.2, range_angle_max=0.3,
                             range_pitch_max=0.4)
    assert robot_msgs.range_to_msg(0.7, settings, STAMP).field_of_view == pytest.approx(0.4)


def test_imu():
    msg = robot_msgs.imu_to_msg(READING, burgers('imu', gyro_noise=0.5, accel_noise=0.25), STAMP)
    assert (msg.header.frame_id, msg.header.stamp) == ('imu_link', STAMP)
    assert msg.angular_velocity_covariance == [0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.25]
    assert msg.linear_acceleration_covariance == [0.0625, 0, 0, 0, 0.0625, 0, 0, 0, 0.0625]


@pytest.mark.parametrize('to_msg, from_msg, settings, values', [
    (robot_msgs.odometry_to_msg, robot_msgs.odometry_from_msg, ODOMETRY,
     (MOTION, Motion(np.array([3.0, 2.0, 1.0]), (0.0, 0.0, 0.6, 0.8), np.zeros(3), np.ones(3)))),
    (robot_msgs.joint_states_to_msg, robot_msgs.joint_states_from_msg, JOINTS,
     (JointStates(('left', 'right'), [0.1, 0.2], [0.3, 0.4], [0.5, 0.6]),
      JointStates(('left', 'right'), [1.1, 1.2], [1.3, 1.4], [1.5, 1.6]))),
    (robot_msgs.scan_to_msg, robot_msgs.scan_from_msg, ScanSettings(),
     (np.arange(360.0), np.full(360, np.inf))),
    (robot_msgs.imu_to_msg, robot_msgs.imu_from_msg, ImuSettings(),
     (READING, ImuReading((0.6, 0.0, 0.0, 0.8), (6.0, 5.0, 4.0), (3.0, 2.0, 1.0))))])
def test_round_trip_and_that_a_message_that_is_used_again_equals_a_new_one(
        to_msg, from_msg, settings, values):
    first, second = values
    stamps = rospy.Time(1, 2), rospy.Time(3, 4)
    msg = to_msg(first, settings, stamps[0])
    assert msg.header.stamp == stamps[0]
    for got, wanted in zip(from_msg(msg), first):
        assert np.array_equal(got, wanted)
    assert to_msg(second, settings, stamps[1], msg) is msg
    assert msg == to_msg(second, settings, stamps[1]) != to_msg(first, settings, stamps[0])


def test_camera_info_round_trip():
    given = Calibration('cam', 640, 480, 'plumb_bob', (0.1, 0.2, 0.0, 0.0, 0.3),
                        tuple(map(float, range(9))), tuple(map(float, range(9, 18))),
                        tuple(map(float, range(18, 30))))
    msg = image_msgs.info_to_msg(given, 1, 1, Header(stamp=STAMP, frame_id='cam'))
    assert (msg.width, msg.height) == (640, 480)
    assert (msg.header.stamp, msg.header.frame_id) == (STAMP, 'cam')
    assert image_msgs.info_from_msg(msg, 'cam') == given


def test_camera_info_without_a_calibration_has_the_size_alone():
    msg = image_msgs.info_to_msg(None, 320, 240, Header())
    assert (msg.width, msg.height, msg.distortion_model, len(msg.D)) == (320, 240, '', 0)
    assert set(msg.K) | set(msg.R) | set(msg.P) == {0.0}


@pytest.fixture
def messages(monkeypatch):
    """Let the messages be there also where gazebo_msgs is not installed."""
    text = DEFINITIONS['gazebo_msgs/msg/ContactsState.msg'] + ''.join(
        '{}\nMSG: {}\n{}'.format('=' * 80, name.replace('/msg/', '/')[:-len('.msg')], definition)
        for name, definition in DEFINITIONS.items() if name.endswith('.msg'))
    made = genpy.dynamic.generate_dynamic('gazebo_msgs/ContactsState', text)
    for name in ('ContactsState', 'ContactState'):
        monkeypatch.setattr(robot_msgs, name, made['gazebo_msgs/' + name])


def test_contacts_and_back(messages):
    points = np.array([(1.0, 2.0, 3.0), (1.0, 2.0, 4.0)])
    touches = [
        Touch('robot::bumper', 'wall::link', points, points / 5, np.array([0.01, 0.02]),
              np.array([(5.0, 0.0, 0.0), (0.0, 6.0, 1.0)]), np.array((1.0, 2.0, 2.0))),
        Touch('robot::bumper', 'post::link', points[:1], points[1:], np.array([0.5]),
              np.array([(0.0, 0.0, 7.0)]), np.zeros(3))]
    msg = robot_msgs.contacts_to_msg(touches, ContactSettings('front'), genpy.Time(3, 4))
    assert (msg.header.frame_id, msg.header.stamp) == ('front', genpy.Time(3, 4))
    first, second = msg.states
    assert (first.collision1_name, second.collision2_name) == (
        'robot::bumper::collision', 'post::link::collision')
    # about the origin of the sensor: 1 m and 2 m above it
    torques = [(each.torque.x, each.torque.y, each.torque.z) for each in first.wrenches]
    assert torques == [(0.0, 5.0, 0.0), (-12.0, 0.0, 0.0)]
    total = first.total_wrench
    assert (total.force.x, total.force.y, total.force.z) == (5.0, 6.0, 1.0)
    assert (total.torque.x, total.torque.y, total.torque.z) == (-12.0, 5.0, 0.0)
    for back, touch in zip(robot_msgs.contacts_from_msg(msg), touches):
        assert back[:2] == touch[:2] and not back.origin.any()
        for got, wanted in zip(back[2:6], touch[2:6]):
            assert got.tolist() == wanted.tolist()
    assert robot_msgs.contacts_to_msg([], ContactSettings(), genpy.Time()).states == []
