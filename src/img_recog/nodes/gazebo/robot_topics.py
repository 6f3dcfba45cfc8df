"""The topics of one simulated robot, or of a model with sensors."""
from typing import Any, Dict, List, Optional, Sequence, Set, Union

import rospy
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist, TwistStamped
from tf2_msgs.msg import TFMessage

from img_recog.conversions import plane_msgs, robot_msgs, twist_msgs
from img_recog.conversions.plane_msgs import PlanePose, PoseError
from img_recog.errors import SimulationError
from img_recog.nodes.gazebo.lockstep import Lockstep
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.simulation_diagnostics import CommandCounts
from img_recog.ros.log.throttle import Throttle, ThrottledWarning
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.simulation.mounted_sensors import MountedSensors, Reading
from img_recog.simulation.sensors.motion_state import MotionState
from img_recog.simulation.sensors.sensor import SensorKind
from img_recog.simulation.simulated_model import Robot

_LOG_PERIOD_S = 0.1             # minimum between two lines about the motion
_WORLD_FRAMES = ('', 'world')


class _Output:
    """Publishes the readings of a sensor.

    publisher: of its topic, which sensors can share; settings: with the names that others see.
    """

    def __init__(self, publisher: DirectPublisher, kind: SensorKind, settings: Any):
        self.publisher = publisher
        self._to_msg, self._settings, self._msg = kind.to_msg, settings, None

    def add(self, reading: Reading) -> Any:
        """Add the message of a reading to those that are published next, and return it."""
        self._msg = self._to_msg(reading.value, self._settings,
                                 robot_msgs.stamp_of(reading.time_s), self._msg)
        self.publisher.add(self._msg)
        return self._msg


class Transforms:
    """Publishes on /tf, the topic of tf2_ros: the transforms of all robots in one message."""

    def __init__(self) -> None:
        self._publisher = DirectPublisher('/tf', TFMessage)
        self._waiting: List[TransformStamped] = []

    def add(self, transform: TransformStamped) -> None:
        """Add a transform to those that are published next; until then it must not be changed,
        except for the next call.
        """
        self._waiting.append(transform)

    def separate(self, transform: TransformStamped) -> None:
        """Call before a transform is changed: what was added so far is a message."""
        if any(each is transform for each in self._waiting):
            self._serialize()

    def flush(self) -> None:
        """Publish what was added."""
        self._serialize()
        self._publisher.flush()

    def _serialize(self) -> None:
        if self._waiting:
            self._publisher.add(TFMessage(self._waiting))
            self._waiting = []


class SensorTopics:
    """Publishes the readings of a model with sensors, or of a robot."""

    _always_read: Set[str] = set()

    def __init__(self, mounted: MountedSensors, lockstep: Optional[Lockstep] = None):
        """Advertise; lockstep: waits for answers."""
        self._mounted, self.spec = mounted, mounted.spec
        names, settings = self.spec.names, mounted.settings.sensors
        self._publishers: Dict[str, DirectPublisher] = {}
        self._outputs: Dict[str, _Output] = {}
        for each in self.spec.sensors:
            if each.kind.is_drawn or each.name in mounted.missing:
                continue
            topic = names.topic(each.kind.topic(settings[each.name]))
            is_answered = lockstep is not None and each.kind.name in lockstep.kinds
            if is_answered:
                self._always_read = {*self._always_read, each.name}
            if topic not in self._publishers:
                self._publishers[topic] = DirectPublisher(
                    topic, each.kind.msg_type,
                    redelivery=lockstep.redelivery if lockstep and is_answered else None)
            self._outputs[each.name] = _Output(self._publishers[topic], each.kind,
                                               names.seen(settings[each.name]))

    def disable_unused(self) -> None:
        """Disable the sensors that have no subscriber."""
        for sensor, output in self._outputs.items():
            if sensor not in self._always_read:
                self._mounted.set_enabled(sensor, output.publisher.get_num_connections() > 0)

    def publish(self, readings: Sequence[Reading]) -> None:
        """Publish readings of the sensors, in order of time."""
        for reading in readings:
            self._add(reading)
        # several messages of a topic together
        for publisher in self._publishers.values():
            publisher.flush()

    def _add(self, reading: Reading) -> Any:
        """Add the message of a reading to those that are published next, and return it."""
        return self._outputs[reading.sensor].add(reading)

    def close(self) -> None:
        """End the topics."""
        for publisher in self._publishers.values():
            publisher.unregister()


class RobotTopics(SensorTopics):
    """Passes commands and poses to a robot, and publishes its readings.

    The poses of ~set_pose, or ~NAMESPACE/set_pose, are in the world or in the frame of the
    odometry.
    """

    _always_read = {'odometry'}         # it is also for tf and the log

    def __init__(self, robot: Robot, transforms: Transforms, calls: ServiceCalls,
                 lockstep: Optional[Lockstep] = None):
        """Advertise and subscribe; transforms: publishes the pose.

        lockstep: waits for answers, which commands may be.
        """
        mounted, = robot.sensors
        super().__init__(mounted, lockstep)
        self.robot, self._calls, names = robot, calls, self.spec.names
        self._is_lockstep = lockstep is not None
        self._counts = CommandCounts()
        self._motion_state, self._log_throttle = MotionState(), Throttle(_LOG_PERIOD_S)
        self._warn = ThrottledWarning()
        self._command_topic = names.topic(robot.settings.drive.command_topic)
        self._commands = LatestValue()
        self._timed_out = False
        self._transforms = transforms
        self._transform = TransformStamped(child_frame_id=names.frame(robot.odometry.base_frame))
        self._pose_topic = rospy.resolve_name('~' + names.topic('set_pose'))
        self._odom_frame = names.frame(robot.odometry.odom_frame)
        self._warn_of_pose = ThrottledWarning()
        self._is_closed = False
        command_type = TwistStamped if robot.settings.drive.stamped_commands else Twist
        self._subscribers = [rospy.Subscriber(self._pose_topic, PoseStamped, self._set_pose,
                                              queue_size=1, tcp_nodelay=True)]
        if robot.settings.drive.is_there:
            self._subscribers.append(
                lockstep.subscribe_commands(self._command_topic, command_type, self._keep_command)
                if lockstep is not None else
                rospy.Subscriber(self._command_topic, command_type, self._keep_command,
                                 queue_size=10, tcp_nodelay=True))

    def _keep_command(self, msg: Union[Twist, TwistStamped]) -> None:
        try:
            # checked here, so that a bad command does not replace a good one
            replaced = self._commands.put(twist_msgs.planar_from_msg(msg))
        except twist_msgs.TwistError as error:
            self._counts.refused.add(error)
            self._warn('ignored a message on %s: %s', self._command_topic, error)
        else:
            self._counts.count_received(replaced is not None)

    def _set_pose(self, msg: PoseStamped) -> None:
        try:
            frame = msg.header.frame_id.lstrip('/')
            if frame not in (*_WORLD_FRAMES, self._odom_frame):
                raise PoseError('its frame is {!r}, expected world or {}'.format(
                    msg.header.frame_id[:100], self._odom_frame))
            pose = plane_msgs.pose_from_msg(msg)
            self._calls.call(lambda: self._move(pose, frame == self._odom_frame))
        except (PoseError, SimulationError) as error:
            self._warn_of_pose('ignored a message on %s: %s', self._pose_topic, error)

    def _move(self, pose: PlanePose, is_in_odometry: bool) -> None:
        if not self._is_closed:
            self.discard_command()
            origin = PlanePose(*self.robot.odometry_origin)
            self.robot.move_to(*(origin.compose(pose) if is_in_odometry else pose))

    def apply_command(self) -> None:
        """Apply the newest command."""
        self._log_timeout()
        command = self._commands.take()
        if command is not None:
            self.robot.command(*command)

    def publish(self, readings: Sequence[Reading]) -> None:
        """Publish readings of the sensors of the robot, in order of time."""
        super().publish(readings)
        self._counts.readings.add(len(readings))

    def _add(self, reading: Reading) -> Any:
        is_pose = reading.sensor == 'odometry'
        if is_pose:
            # it shares its header with the message, which is changed now
            self._transforms.separate(self._transform)
        msg = super()._add(reading)
        if is_pose:
            self._log_motion_change(reading)
            if self.robot.odometry.publish_odom_tf:
                self._transforms.add(robot_msgs.transform_of(msg, self._transform))
        return msg

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add the counters to a status; to be called once in each period."""
        drive = self.robot.drive
        self._counts.report(status, drive.timeout_s, drive.timed_out)

    def discard_command(self) -> None:
        """Drop a command that was not applied yet: after a reset it is out of date."""
        self._commands.take()

    def _log_timeout(self) -> None:
        timed_out = self.robot.drive.timed_out
        if timed_out and not self._timed_out:
            rospy.logwarn('no command on %s for %g s of simulated time: %s is stopped',
                          self._command_topic, self.robot.drive.timeout_s,
                          self.spec.names.words)
        self._timed_out = timed_out

    def _log_motion_change(self, reading: Reading) -> None:
        # in lockstep, the lines of equal runs are the same
        if self._log_throttle.ready(reading.time_s if self._is_lockstep else None):
            change = self._motion_state.update(reading.value)
            if change is not None:
                rospy.loginfo('%s %s, at x %.2f m, y %.2f m', self.spec.names.words, change,
                              *reading.value.position[:2])

    def close(self) -> None:
        """End the topics."""
        self._is_closed = True
        for subscriber in self._subscribers:
            subscriber.unregister()
        super().close()
