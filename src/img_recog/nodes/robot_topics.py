"""The topics of one simulated robot."""
from dataclasses import dataclass
from typing import Callable, NamedTuple

import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState, LaserScan

from img_recog.nodes import robot_msgs, sensing_msgs, twist_msgs
from img_recog.nodes.prompt_publisher import PromptPublisher
from img_recog.nodes.slots import Newest
from img_recog.nodes.throttle import Throttle, ThrottledWarning
from img_recog.settings import Settings, not_empty, setting
from img_recog.simulation.motion_state import MotionState
from img_recog.simulation.vehicle import Reading, Vehicle

_NEWS_PERIOD_S = 0.1            # of wall time, between two lines about how the robot moves


@dataclass(frozen=True)
class TopicSettings(Settings):
    """Names of topics, by the names that Gazebo's plugins have for them."""

    command_topic: str = setting('cmd_vel', not_empty())
    odometry_topic: str = setting('odom', not_empty())
    imu_topic: str = setting('imu', not_empty())
    scan_topic: str = setting('scan', not_empty())


class _Output(NamedTuple):
    """Where the readings of a sensor go, and how they get there."""

    publisher: PromptPublisher
    publish: Callable[[Reading], None]


class RobotTopics:
    """Hands commands to a vehicle, and its readings to ROS."""

    def __init__(self, vehicle: Vehicle, names: TopicSettings):
        self._vehicle = vehicle
        settings = vehicle.settings
        self._scan, self._imu, self._odometry = settings.scan, settings.imu, settings.odometry
        self._base_frame = settings.odometry.base_frame or vehicle.robot.root
        self._motion_state, self._news = MotionState(), Throttle(_NEWS_PERIOD_S)
        self._warn = ThrottledWarning()
        self._commands = Newest()
        self._transforms = tf2_ros.TransformBroadcaster()
        self._outputs = {
            'odometry': _Output(PromptPublisher(names.odometry_topic, Odometry),
                                self._publish_odometry),
            'joint_states': _Output(PromptPublisher('joint_states', JointState),
                                    self._publish_joint_states),
            'imu': _Output(PromptPublisher(names.imu_topic, Imu),
                           self._publish_imu),
            'scan': _Output(PromptPublisher(names.scan_topic, LaserScan),
                            self._publish_scan)}
        rospy.Subscriber(names.command_topic, Twist, self._keep_command, queue_size=10,
                         tcp_nodelay=True)

    def _keep_command(self, msg: Twist) -> None:
        try:
            # looked at here, so that a bad command does not replace a good one
            self._commands.put(twist_msgs.from_msg(msg))
        except twist_msgs.TwistError as error:
            self._warn('cmd_vel ignored: %s', error)

    def before(self) -> None:
        """Obey the newest command, and switch off the sensors that nobody listens to."""
        command = self._commands.take()
        if command is not None:
            self._vehicle.command(*command)
        for sensor in ('joint_states', 'imu', 'scan'):
            publisher = self._outputs[sensor].publisher
            self._vehicle.switch(sensor, publisher.get_num_connections() > 0)

    def publish(self, reading: Reading) -> None:
        """Publish what a sensor of the vehicle saw."""
        self._outputs[reading.sensor].publish(reading)

    def forget_command(self) -> None:
        """Drop a command that has come and was not obeyed yet: one from before a reset."""
        self._commands.take()

    def _publish_odometry(self, reading: Reading) -> None:
        self._tell_news(reading)
        msg = robot_msgs.odometry_to_msg(reading.value, robot_msgs.stamp_of(reading.time_s),
                                         self._odometry.odom_frame, self._base_frame)
        self._outputs['odometry'].publisher.publish(msg)
        if self._odometry.publish_odom_tf:
            self._transforms.sendTransform(robot_msgs.transform_of(msg))

    def _tell_news(self, reading: Reading) -> None:
        if self._news.ready():
            news = self._motion_state.update(reading.value)
            if news is not None:
                rospy.loginfo('the robot %s, at x %.2f m, y %.2f m', news,
                              *reading.value.position[:2])

    def _publish_joint_states(self, reading: Reading) -> None:
        self._outputs['joint_states'].publisher.publish(robot_msgs.joint_states_to_msg(
            reading.value, robot_msgs.stamp_of(reading.time_s)))

    def _publish_imu(self, reading: Reading) -> None:
        self._outputs['imu'].publisher.publish(sensing_msgs.imu_to_msg(
            reading.value, robot_msgs.stamp_of(reading.time_s), self._imu))

    def _publish_scan(self, reading: Reading) -> None:
        self._outputs['scan'].publisher.publish(sensing_msgs.scan_to_msg(
            reading.value, robot_msgs.stamp_of(reading.time_s), self._scan))
