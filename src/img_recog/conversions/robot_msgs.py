"""Converts nav_msgs/Odometry and sensor_msgs/JointState, LaserScan and Imu.

The values are those of the simulation; `stamp` is always the last argument of a `to_msg`.
"""
from typing import List

import genpy
import numpy as np
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState, LaserScan

from img_recog.simulation.body import Motion
from img_recog.simulation.imu import ImuReading
from img_recog.simulation.robot import JointStates
from img_recog.simulation.settings import ImuSettings, ScanSettings

# of x, y, z, roll, pitch, yaw (libgazebo_ros_diff_drive): z, roll and pitch are not estimated
_POSE_COVARIANCE = np.diag((1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)).ravel().tolist()


def stamp_of(time_s: float) -> genpy.Time:
    """Return simulated time as a stamp, to the nearest nanosecond (from_sec truncates)."""
    return genpy.Time(*divmod(round(time_s * 1e9), 1000000000))


def odometry_to_msg(motion: Motion, frame_id: str, child_frame_id: str,
                    stamp: genpy.Time) -> Odometry:
    """Return the message for a motion: pose in `frame_id`, twist in `child_frame_id`."""
    msg = Odometry(child_frame_id=child_frame_id)
    msg.header.stamp, msg.header.frame_id = stamp, frame_id
    msg.pose.pose.position = Point(*motion.position)
    msg.pose.pose.orientation = Quaternion(*motion.orientation)
    msg.pose.covariance = _POSE_COVARIANCE
    msg.twist.twist.linear = Vector3(*motion.linear)
    msg.twist.twist.angular = Vector3(*motion.angular)
    return msg


def odometry_from_msg(msg: Odometry) -> Motion:
    """Return the motion in a message."""
    pose, twist = msg.pose.pose, msg.twist.twist
    orientation = pose.orientation
    return Motion(_array(pose.position),
                  (orientation.x, orientation.y, orientation.z, orientation.w),
                  _array(twist.linear), _array(twist.angular))


def transform_of(odometry: Odometry) -> TransformStamped:
    """Return the transform of an odometry message, from its frame to its child frame."""
    transform = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    position = odometry.pose.pose.position
    transform.transform.translation = Vector3(position.x, position.y, position.z)
    transform.transform.rotation = odometry.pose.pose.orientation
    return transform


def joint_states_to_msg(states: JointStates, stamp: genpy.Time) -> JointState:
    """Return the message for joint states: rad, rad/s and N m."""
    msg = JointState(name=list(states.names), position=list(states.positions),
                     velocity=list(states.velocities), effort=list(states.efforts))
    msg.header.stamp = stamp
    return msg


def joint_states_from_msg(msg: JointState) -> JointStates:
    """Return the joint states in a message."""
    return JointStates(tuple(msg.name), list(msg.position), list(msg.velocity), list(msg.effort))


def scan_to_msg(ranges: np.ndarray, settings: ScanSettings, stamp: genpy.Time) -> LaserScan:
    """Return the message for ranges in m, one per ray; all rays are cast at `stamp`."""
    msg = LaserScan(angle_min=settings.scan_angle_min, angle_max=settings.scan_angle_max,
                    range_min=settings.scan_range_min, range_max=settings.scan_range_max,
                    ranges=ranges.tolist(), intensities=[0.0] * len(ranges))
    msg.angle_increment = (msg.angle_max - msg.angle_min) / (len(ranges) - 1)
    msg.header.stamp, msg.header.frame_id = stamp, settings.scan_frame
    return msg


def scan_from_msg(msg: LaserScan) -> np.ndarray:
    """Return the ranges of a message in m, float64 of shape (rays,)."""
    return np.array(msg.ranges)


def imu_to_msg(reading: ImuReading, settings: ImuSettings, stamp: genpy.Time) -> Imu:
    """Return the message for a reading; the covariances are those of the noise."""
    msg = Imu(orientation=Quaternion(*reading.orientation),
              angular_velocity=Vector3(*reading.angular_velocity),
              linear_acceleration=Vector3(*reading.linear_acceleration))
    msg.header.stamp, msg.header.frame_id = stamp, settings.imu_frame
    msg.angular_velocity_covariance = _isotropic(settings.gyro_noise ** 2)
    msg.linear_acceleration_covariance = _isotropic(settings.accel_noise ** 2)
    return msg


def imu_from_msg(msg: Imu) -> ImuReading:
    """Return the reading in a message."""
    turned, rate, force = msg.orientation, msg.angular_velocity, msg.linear_acceleration
    return ImuReading((turned.x, turned.y, turned.z, turned.w), np.array([rate.x, rate.y, rate.z]),
                      np.array([force.x, force.y, force.z]))


def _isotropic(variance: float) -> List[float]:
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]


def _array(vector) -> np.ndarray:
    return np.array([vector.x, vector.y, vector.z])
