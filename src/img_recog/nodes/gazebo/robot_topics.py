"""The topics of one simulated robot."""
from dataclasses import dataclass
from typing import Any, Callable, NamedTuple

import rospy
import tf2_ros
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState, LaserScan

from img_recog.conversions import robot_msgs, twist_msgs
from img_recog.nodes.gazebo.diagnostics import CommandCounts
from img_recog.ros.queues import LatestValue
from img_recog.ros.throttle import Throttle, ThrottledWarning
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.settings import Settings, not_empty, setting
from img_recog.simulation.motion_state import MotionState
from img_recog.simulation.vehicle import Reading, Vehicle

_LOG_PERIOD_S = 0.1             # of wall time: minimum between two lines about the motion


@dataclass(frozen=True)
class TopicSettings(Settings):
    """Names of topics; the settings are named like the tags of Gazebo's plugins."""

    command_topic: str = setting('cmd_vel', not_empty())
    odometry_topic: str = setting('odom', not_empty())
    imu_topic: str = setting('imu', not_empty())
    scan_topic: str = setting('scan', not_empty())


class _Output(NamedTuple):
    """How readings of a sensor are published; to_msg(value, stamp) returns the message."""

    publisher: DirectPublisher
    to_msg: Callable[[Any, rospy.Time], Any]


class RobotTopics:
    """Passes commands to a vehicle, and publishes its readings."""

    def __init__(self, vehicle: Vehicle, names: TopicSettings):
        self._vehicle = vehicle
        self._counts = CommandCounts()
        settings = vehicle.settings
        odometry = settings.odometry
        base_frame = odometry.base_frame or vehicle.robot.root
        self._publishes_tf = odometry.publish_odom_tf
        self._motion_state, self._log_throttle = MotionState(), Throttle(_LOG_PERIOD_S)
        self._warn = ThrottledWarning()
        self._command_topic = names.command_topic
        self._commands = LatestValue()
        self._timed_out = False
        self._transforms = tf2_ros.TransformBroadcaster()
        self._outputs = {
            'odometry': _Output(
                DirectPublisher(names.odometry_topic, Odometry),
                lambda value, stamp: robot_msgs.odometry_to_msg(
                    value, odometry.odom_frame, base_frame, stamp)),
            'joint_states': _Output(DirectPublisher('joint_states', JointState),
                                    robot_msgs.joint_states_to_msg),
            'imu': _Output(
                DirectPublisher(names.imu_topic, Imu),
                lambda value, stamp: robot_msgs.imu_to_msg(value, settings.imu, stamp)),
            'scan': _Output(
                DirectPublisher(names.scan_topic, LaserScan),
                lambda value, stamp: robot_msgs.scan_to_msg(value, settings.scan, stamp))}
        rospy.Subscriber(names.command_topic, Twist, self._keep_command, queue_size=10,
                         tcp_nodelay=True)

    def _keep_command(self, msg: Twist) -> None:
        try:
            # checked here, so that a bad command does not replace a good one
            replaced = self._commands.put(twist_msgs.from_msg(msg))
        except twist_msgs.TwistError as error:
            self._counts.refused.add(error)
            self._warn('ignored a message on %s: %s', self._command_topic, error)
        else:
            self._counts.count_received(replaced is not None)

    def apply_command(self) -> None:
        """Apply the newest command, and disable the sensors that have no subscriber."""
        self._log_timeout()
        command = self._commands.take()
        if command is not None:
            self._vehicle.command(*command)
        for sensor in ('joint_states', 'imu', 'scan'):
            publisher = self._outputs[sensor].publisher
            self._vehicle.set_sensor_enabled(sensor, publisher.get_num_connections() > 0)

    def publish(self, reading: Reading) -> None:
        """Publish a reading of a sensor of the vehicle."""
        output = self._outputs[reading.sensor]
        msg = output.to_msg(reading.value, robot_msgs.stamp_of(reading.time_s))
        output.publisher.publish(msg)
        self._counts.readings.add()
        if reading.sensor == 'odometry':
            self._log_motion_change(reading)
            if self._publishes_tf:
                self._transforms.sendTransform(robot_msgs.transform_of(msg))

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add the counters to a status; to be called once in each period."""
        self._counts.report(status, self._vehicle.settings.drive.cmd_vel_timeout,
                            self._vehicle.command_timed_out)

    def discard_command(self) -> None:
        """Drop a command that was not applied yet: after a reset it is out of date."""
        self._commands.take()

    def _log_timeout(self) -> None:
        timed_out = self._vehicle.command_timed_out
        if timed_out and not self._timed_out:
            rospy.logwarn('no command on %s for %g s of simulated time: the robot is stopped',
                          self._command_topic, self._vehicle.settings.drive.cmd_vel_timeout)
        self._timed_out = timed_out

    def _log_motion_change(self, reading: Reading) -> None:
        if self._log_throttle.ready():
            change = self._motion_state.update(reading.value)
            if change is not None:
                rospy.loginfo('the robot %s, at x %.2f m, y %.2f m', change,
                              *reading.value.position[:2])
