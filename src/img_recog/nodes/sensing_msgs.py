"""sensor_msgs/LaserScan and sensor_msgs/Imu to and from the simulation."""
import numpy as np
import rospy
from geometry_msgs.msg import Quaternion, Vector3
from sensor_msgs.msg import Imu, LaserScan

from img_recog.simulation.imu import Inertial
from img_recog.simulation.settings import ImuSettings, ScanSettings


def scan_to_msg(ranges: np.ndarray, stamp: rospy.Time, settings: ScanSettings) -> LaserScan:
    """Return the message for ranges in m, one a ray; all rays are cast at `stamp`."""
    msg = LaserScan(angle_min=settings.scan_angle_min, angle_max=settings.scan_angle_max,
                    range_min=settings.scan_range_min, range_max=settings.scan_range_max,
                    ranges=ranges.tolist(), intensities=[0.0] * len(ranges))
    msg.angle_increment = (msg.angle_max - msg.angle_min) / (len(ranges) - 1)
    msg.header.stamp, msg.header.frame_id = stamp, settings.scan_frame
    return msg


def scan_from_msg(msg: LaserScan) -> np.ndarray:
    """Return the ranges of a message in m, float64 of shape (rays,)."""
    return np.array(msg.ranges)


def imu_to_msg(inertial: Inertial, stamp: rospy.Time, settings: ImuSettings) -> Imu:
    """Return the message for a measurement; the covariances are those of the noise."""
    msg = Imu(orientation=Quaternion(*inertial.orientation),
              angular_velocity=Vector3(*inertial.angular_velocity),
              linear_acceleration=Vector3(*inertial.linear_acceleration))
    msg.header.stamp, msg.header.frame_id = stamp, settings.imu_frame
    msg.angular_velocity_covariance = _isotropic(settings.gyro_noise ** 2)
    msg.linear_acceleration_covariance = _isotropic(settings.accel_noise ** 2)
    return msg


def imu_from_msg(msg: Imu) -> Inertial:
    """Return the measurement in a message."""
    turned, rate, force = msg.orientation, msg.angular_velocity, msg.linear_acceleration
    return Inertial((turned.x, turned.y, turned.z, turned.w), np.array([rate.x, rate.y, rate.z]),
                    np.array([force.x, force.y, force.z]))


def _isotropic(variance: float) -> list:
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
