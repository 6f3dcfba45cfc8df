"""Converts nav_msgs/Odometry, sensor_msgs/JointState, LaserScan, Range and Imu, and
gazebo_msgs/ContactsState; reads and makes stamps.

The values are those of the simulation, and the frames in settings are those that others see.
With the message of an earlier call with the same settings as `out`, a `to_msg` changes that one:
to make a message takes longer than to fill it.

NO_CONTACTS says why the package gazebo_msgs cannot be used, '' if it can.
"""
import functools
import struct
from typing import Any, List, Optional, Sequence, Union

import genpy
import numpy as np
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3, Wrench
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState, LaserScan, Range

from img_recog.errors import one_line
from img_recog.simulation.physics.body import Motion, Vector
from img_recog.simulation.physics.robot import JointStates
from img_recog.simulation.sensors.contact_sensor import ContactSettings, Touch
from img_recog.simulation.sensors.imu import ImuReading, ImuSettings
from img_recog.simulation.sensors.joint_states import JointStateSettings
from img_recog.simulation.sensors.laser_scanner import ScanSettings
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.sensors.range_sensor import ULTRASOUND, RangeSettings

try:
    from gazebo_msgs.msg import ContactsState, ContactState
    NO_CONTACTS = ''
except ImportError as error:
    ContactsState = ContactState = None
    NO_CONTACTS = 'gazebo_msgs cannot be loaded: {}'.format(one_line(error))

_COLLISION = '::collision'      # PyBullet does not keep the names of shapes
_SEQ_AND_STAMP = struct.Struct('<III')      # at the beginning of a serialized header
_HEADER_TYPES = ('Header header', 'std_msgs/Header header')
# of x, y, z, roll, pitch, yaw (libgazebo_ros_diff_drive): z, roll and pitch are not estimated
_POSE_COVARIANCE = np.diag((1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)).ravel().tolist()


@functools.lru_cache(maxsize=8)         # what is measured at the same time has the same stamp
def stamp_of(time_s: float) -> genpy.Time:
    """Return simulated time as a stamp, to the nearest nanosecond (from_sec truncates).

    >>> stamp_of(1.1)
    genpy.Time[1100000000]

    It must not be changed.
    """
    stamp = genpy.Time.__new__(genpy.Time)      # its checks take ten times as long as the rest
    stamp.secs, stamp.nsecs = divmod(round(time_s * 1e9), 1000000000)
    return stamp


def stamp_in(data: bytes, type_name: str, definition: str) -> Optional[genpy.Time]:
    """Return the stamp in a serialized message, None if its type has no header as first field.

    >>> stamp_in(bytes([0] * 4 + [5, 0, 0, 0] * 2), 'my/Type', 'int8 NO=0\\nHeader header').secs
    5
    """
    lines = (line.split('#')[0].strip() for line in definition.splitlines())
    first = next((line for line in lines if line and '=' not in line), '')
    if type_name != 'std_msgs/Header' and ' '.join(first.split()) not in _HEADER_TYPES:
        return None
    return genpy.Time(*_SEQ_AND_STAMP.unpack_from(data)[1:])


def odometry_to_msg(motion: Motion, settings: OdometrySettings, stamp: genpy.Time,
                    out: Optional[Odometry] = None) -> Odometry:
    """Return the message for a motion: pose in `odom_frame`, twist in `base_frame`."""
    if out is None:
        out = Odometry(child_frame_id=settings.base_frame)
        out.header.frame_id = settings.odom_frame
        out.pose.covariance = _POSE_COVARIANCE
    out.header.stamp = stamp
    _set_vector(out.pose.pose.position, motion.position.tolist())
    _set_quaternion(out.pose.pose.orientation, motion.orientation)
    _set_vector(out.twist.twist.linear, motion.linear.tolist())
    _set_vector(out.twist.twist.angular, motion.angular.tolist())
    return out


def odometry_from_msg(msg: Odometry) -> Motion:
    """Return the motion in a message."""
    pose, twist = msg.pose.pose, msg.twist.twist
    orientation = pose.orientation
    return Motion(_array(pose.position),
                  (orientation.x, orientation.y, orientation.z, orientation.w),
                  _array(twist.linear), _array(twist.angular))


def transform_of(odometry: Odometry, out: Optional[TransformStamped] = None) -> TransformStamped:
    """Return the transform of an odometry message, from its frame to its child frame."""
    if out is None:
        out = TransformStamped(child_frame_id=odometry.child_frame_id)
    position, translation = odometry.pose.pose.position, out.transform.translation
    out.header, out.transform.rotation = odometry.header, odometry.pose.pose.orientation
    translation.x, translation.y, translation.z = position.x, position.y, position.z
    return out


def joint_states_to_msg(states: JointStates, _: JointStateSettings, stamp: genpy.Time,
                        out: Optional[JointState] = None) -> JointState:
    """Return the message for joint states: rad, rad/s and N m."""
    if out is None:
        out = JointState(name=list(states.names))
    out.header.stamp = stamp
    out.position, out.velocity = list(states.positions), list(states.velocities)
    out.effort = list(states.efforts)
    return out


def joint_states_from_msg(msg: JointState) -> JointStates:
    """Return the joint states in a message."""
    return JointStates(tuple(msg.name), list(msg.position), list(msg.velocity), list(msg.effort))


def scan_to_msg(ranges: np.ndarray, settings: ScanSettings, stamp: genpy.Time,
                out: Optional[LaserScan] = None) -> LaserScan:
    """Return the message for the middle row of ranges in m, all measured at `stamp`."""
    ranges = settings.middle(ranges)
    if out is None:
        first, last = settings.scan_angle_min, settings.scan_angle_max
        out = LaserScan(angle_min=first, angle_max=last, range_min=settings.scan_range_min,
                        range_max=settings.scan_range_max, intensities=[0.0] * len(ranges),
                        angle_increment=(last - first) / max(1, len(ranges) - 1))
        out.header.frame_id = settings.scan_frame
    out.header.stamp, out.ranges = stamp, ranges.tolist()
    return out


def scan_from_msg(msg: LaserScan) -> np.ndarray:
    """Return the ranges of a message in m, float64 of shape (rays,)."""
    return np.array(msg.ranges)


def range_to_msg(distance: float, settings: RangeSettings, stamp: genpy.Time,
                 out: Optional[Range] = None) -> Range:
    """Return the message for a distance in m."""
    if out is None:
        is_sonar = settings.range_radiation == ULTRASOUND
        out = Range(radiation_type=Range.ULTRASOUND if is_sonar else Range.INFRARED,
                    field_of_view=settings.field_of_view(), min_range=settings.range_min,
                    max_range=settings.range_max)
        out.header.frame_id = settings.range_frame
    out.header.stamp, out.range = stamp, distance
    return out


def range_from_msg(msg: Range) -> float:
    """Return the distance in a message in m."""
    return msg.range


def imu_to_msg(reading: ImuReading, settings: ImuSettings, stamp: genpy.Time,
               out: Optional[Imu] = None) -> Imu:
    """Return the message for a reading; the covariances are those of the noise."""
    if out is None:
        out = Imu(angular_velocity_covariance=_isotropic(settings.gyro_noise ** 2),
                  linear_acceleration_covariance=_isotropic(settings.accel_noise ** 2))
        out.header.frame_id = settings.imu_frame
    out.header.stamp = stamp
    _set_quaternion(out.orientation, reading.orientation)
    _set_vector(out.angular_velocity, reading.angular_velocity)
    _set_vector(out.linear_acceleration, reading.linear_acceleration)
    return out


def imu_from_msg(msg: Imu) -> ImuReading:
    """Return the reading in a message."""
    turned, rate, force = msg.orientation, msg.angular_velocity, msg.linear_acceleration
    return ImuReading((turned.x, turned.y, turned.z, turned.w), (rate.x, rate.y, rate.z),
                      (force.x, force.y, force.z))


def contacts_to_msg(touches: List[Touch], settings: ContactSettings, stamp: genpy.Time,
                    _: Any = None) -> Any:
    """Return the message for what touches; torques are about the origin of the sensor.

    Like in gazebo_plugins, all is in the world, whatever the frame is called.
    """
    msg = ContactsState(states=[_state(touch) for touch in touches])
    msg.header.frame_id, msg.header.stamp = settings.contact_frame, stamp
    return msg


def contacts_from_msg(msg: Any) -> List[Touch]:
    """Return what a message says; the origin, which it does not say, is 0 0 0."""
    return [Touch(state.collision1_name[:-len(_COLLISION)],
                  state.collision2_name[:-len(_COLLISION)],
                  _arrays(state.contact_positions), _arrays(state.contact_normals),
                  np.array(state.depths), _arrays([wrench.force for wrench in state.wrenches]),
                  np.zeros(3)) for state in msg.states]


def _state(touch: Touch) -> Any:
    torques = np.cross(touch.positions - touch.origin, touch.forces)
    return ContactState(
        collision1_name=touch.own + _COLLISION, collision2_name=touch.other + _COLLISION,
        wrenches=[Wrench(Vector3(*force), Vector3(*torque))
                  for force, torque in zip(touch.forces, torques)],
        total_wrench=Wrench(Vector3(*touch.forces.sum(axis=0)), Vector3(*torques.sum(axis=0))),
        contact_positions=[Vector3(*each) for each in touch.positions],
        contact_normals=[Vector3(*each) for each in touch.normals],
        depths=touch.depths.tolist())


def _isotropic(variance: float) -> List[float]:
    return [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]


def _set_vector(msg: Union[Point, Vector3], vector: Vector) -> None:
    msg.x, msg.y, msg.z = vector


def _set_quaternion(msg: Quaternion, quaternion: Sequence[float]) -> None:
    msg.x, msg.y, msg.z, msg.w = quaternion


def _array(vector) -> np.ndarray:
    return np.array([vector.x, vector.y, vector.z])


def _arrays(vectors) -> np.ndarray:
    return np.array([_array(vector) for vector in vectors])
