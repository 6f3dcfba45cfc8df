"""The topics of simulated robots, and of models with sensors, added and removed while it runs."""
from typing import Any, Collection, Dict, List, Optional, Sequence, Set, Union

import rospy
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist, TwistStamped

from img_recog.conversions import plane_msgs, robot_msgs, twist_msgs
from img_recog.conversions.plane_msgs import PlanePose, PoseError
from img_recog.conversions.sensor_table import SENSORS
from img_recog.conversions.topic_checks import check_topics
from img_recog.errors import SimulationError, UserError, one_line
from img_recog.nodes.gazebo.command_counts import CommandCounts
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.lockstep import Lockstep
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.robot_reader import in_namespace
from img_recog.nodes.gazebo.transforms import StaticTransforms, Transforms, plane_transform
from img_recog.report import Report
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.ros.queues import LatestValue
from img_recog.ros.throttle import Throttle, ThrottledWarning
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.simulation import assembly
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.models import Models
from img_recog.simulation.sensors.motion_state import MotionState
from img_recog.simulation.sensors.sensor import SensorKind
from img_recog.simulation.simulated_model import (MountedSensors, Reading, Robot,
                                                  SimulatedModel)
from img_recog.simulation.simulator import Simulator

WORLD_FRAME = 'world'
_LOG_PERIOD_S = 0.1             # minimum between two lines about the motion
_WORLD_FRAMES = ('', WORLD_FRAME)


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


class ModelTopics:
    """Publishes the readings of a model with sensors, or of a robot."""

    _always_read: Set[str] = set()

    def __init__(self, mounted: MountedSensors, lockstep: Optional[Lockstep] = None):
        """Advertise; lockstep: waits for answers."""
        self._mounted, self.spec = mounted, mounted.spec
        names, settings = self.spec.names, mounted.settings.sensors
        self._publishers: Dict[str, DirectPublisher] = {}
        self._outputs: Dict[str, _Output] = {}
        for each in mounted.published:
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


class RobotTopics(ModelTopics):
    """Passes commands and poses to a robot, and publishes its readings.

    The poses of ~set_pose, or ~NAMESPACE/set_pose, are in the world or in the frame of the
    odometry.
    """

    _always_read = {'odometry'}         # it is also for tf and the log

    def __init__(self, robot: Robot, transforms: Transforms, calls: ServiceCalls,
                 lockstep: Lockstep):
        """Advertise and subscribe; transforms: publishes the pose.

        lockstep: waits for answers, which commands may be.
        """
        mounted, = robot.sensors
        super().__init__(mounted, lockstep)
        self.robot, self._calls, names = robot, calls, self.spec.names
        self._is_lockstep = lockstep.is_on
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
        self._is_closed = False
        command_type = TwistStamped if robot.settings.drive.stamped_commands else Twist
        self._subscribers = [rospy.Subscriber(self._pose_topic, PoseStamped, self._set_pose,
                                              queue_size=1, tcp_nodelay=True)]
        if robot.settings.drive.is_there:
            self._subscribers.append(lockstep.subscribe_commands(
                self._command_topic, command_type, self._keep_command))

    def _keep_command(self, msg: Union[Twist, TwistStamped]) -> None:
        try:
            # checked here, so that a bad command does not replace a good one
            replaced = self._commands.put(twist_msgs.from_msg(msg))
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
            self._warn('ignored a message on %s: %s', self._pose_topic, error)

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


class WorldTopics:
    """The topics of all models of a world.

    All methods are for the thread that simulates, `report` for any.

    world_tf: whether static transforms from the world to the odometry frames of robots with a
    namespace are published. lockstep: see RobotTopics.
    """

    def __init__(self, simulator: Simulator, models: Models, images: Images,
                 statics: StaticTransforms, calls: ServiceCalls, world_tf: bool,
                 lockstep: Lockstep):
        self._simulator, self._models, self._images = simulator, models, images
        self._statics, self._calls, self._world_tf = statics, calls, world_tf
        self._lockstep = lockstep
        self._diagnostics: Optional[NodeDiagnostics] = None
        self._transforms = Transforms()
        self._timeout_scale = 1.0
        self._topics: Dict[str, ModelTopics] = {}       # by the names of bodies
        # the robots among them; replaced as a whole, because /diagnostics reads it in its thread
        self._robots: Dict[str, RobotTopics] = {}

    def add(self, spec: ConfiguredModel) -> None:
        """Add a robot, apart from the others and the walls, and log its warnings.

        Raises a UserError when that cannot be; nothing has changed then.
        """
        if spec.name in self._models:
            raise SimulationError('there is a model {} already'.format(spec.name),
                                  'give another name')
        self._check_namespace(spec)
        report = Report()
        assembly.add_robot_apart(self._simulator, spec, report)
        robot = self._simulator.robots[-1]
        try:
            self.connect(robot)
        except UserError:
            self._simulator.world.remove(robot)
            raise
        self._simulator.world.report.extend([*spec.findings, *report.findings])
        rospy.loginfo('added %s: %.4f kg with root link %s', spec.names.words,
                      robot.body.mass(), robot.body.root)
        self.log_start(robot)

    def add_sensors(self, model: SimulatedModel) -> None:
        """Add the sensors that the file of a model has, with their topics."""
        assembly.add_sensors(self._simulator.world, model, SENSORS)
        self.connect_of_file(model)

    def _check_namespace(self, spec: ConfiguredModel) -> None:
        if spec.names.namespace in self.namespaces():
            raise SimulationError('there is a robot with the namespace {!r} already'.format(
                spec.names.namespace), 'give it another robot_namespace')

    def log_start(self, robot: Robot) -> None:
        """Log where a robot starts."""
        spawn = robot.settings.spawn
        rospy.loginfo('%s is at the start: x %.2f m, y %.2f m, yaw %.2f rad',
                      robot.spec.names.words, spawn.x_pos, spawn.y_pos, spawn.yaw)

    def connect(self, model: SimulatedModel) -> None:
        """Give the sensors of a model their topics, and a robot those of its drive.

        Raises a UserError when two sensors have the same topic, or those of its cameras cannot be
        used.
        """
        for mounted in model.sensors:
            self._connect(model, mounted)

    def _connect(self, model: SimulatedModel, mounted: MountedSensors) -> None:
        spec, name = mounted.spec, mounted.body.name
        check_topics(spec, [each.spec for each in self._topics.values()], rospy.resolve_name)
        self._images.add_cameras(mounted)
        if not isinstance(model, Robot):
            self._topics[name] = ModelTopics(mounted)
            return
        model.drive.scale_timeout(self._timeout_scale)
        robot = RobotTopics(model, self._transforms, self._calls, self._lockstep)
        self._topics[name], self._robots = robot, {**self._robots, name: robot}
        odometry = model.odometry
        if self._world_tf and spec.names.namespace and odometry.publish_odom_tf:
            self._statics.set('world of ' + name, [plane_transform(
                PlanePose(*model.odometry_origin), WORLD_FRAME,
                spec.names.frame(odometry.odom_frame))])
        self._add_diagnostics(name)

    def connect_of_file(self, model: SimulatedModel) -> None:
        """Give a model of the world that drives or has sensors its topics.

        Where that cannot be, a line of the log says why, and it has none.
        """
        for mounted in model.sensors:
            mounted.spec = in_namespace(mounted.spec)
            try:
                if model.is_robot:
                    self._check_namespace(mounted.spec)
                self._connect(model, mounted)
            except UserError as error:
                rospy.logerr('model %s has no topics: %s', mounted.body.name, one_line(error))

    def remove(self, name: str) -> None:
        """Remove a model with its topics; SimulationError for the floor, and if there is none."""
        for mounted in self._models.remove(name).sensors:
            self._images.remove_cameras(mounted)
            topics = self._topics.pop(mounted.body.name, None)
            if topics is None:
                continue
            topics.close()
            if topics in self._robots.values():
                self._robots = {key: each for key, each in self._robots.items()
                                if each is not topics}
                namespace = topics.spec.names.namespace
                if self._diagnostics is not None and namespace:
                    self._diagnostics.remove(mounted.body.name)
                if namespace:
                    self._lockstep.forget(namespace)
                self._statics.remove('world of ' + mounted.body.name)
                rospy.loginfo('%s was removed', topics.spec.names.words)

    def __contains__(self, name: str) -> bool:
        return name in self._robots

    def apply_commands(self) -> None:
        """Apply the newest commands."""
        for robot in self._robots.values():
            robot.apply_command()

    def disable_unused(self) -> None:
        """Disable the sensors that have no subscriber."""
        for topics in self._topics.values():
            topics.disable_unused()

    def namespaces(self, names: Optional[Collection[str]] = None) -> List[str]:
        """Return the namespaces of the robots with some names, or of all."""
        return [robot.spec.names.namespace for name, robot in self._robots.items()
                if names is None or name in names]

    def discard_commands(self) -> None:
        """Drop commands that were not applied yet."""
        for robot in self._robots.values():
            robot.discard_command()

    def publish(self, readings: Sequence[Reading]) -> None:
        """Publish the readings of all sensors but cameras."""
        found: Dict[str, List[Reading]] = {name: [] for name in self._topics}
        for reading in readings:
            if reading.robot in found and not self._images.is_camera(reading):
                found[reading.robot].append(reading)
        for name, topics in self._topics.items():
            topics.publish(found[name])
        self._transforms.flush()

    def scale_timeouts(self, scale: float) -> None:
        """Make `cmd_vel_timeout` of all robots, also later ones, `scale` times as long."""
        self._timeout_scale = scale
        for robot in self._robots.values():
            robot.robot.drive.scale_timeout(scale)

    def use_diagnostics(self, diagnostics: NodeDiagnostics) -> None:
        """Report each robot with a namespace as a separate status from now on."""
        self._diagnostics = diagnostics
        for name in self._robots:
            self._add_diagnostics(name)

    def _add_diagnostics(self, name: str) -> None:
        robot = self._robots[name]
        if self._diagnostics is not None and robot.spec.names.namespace:
            self._diagnostics.add(name, robot.report)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add the robot without a namespace to a status; to be called once in each period."""
        for robot in self._robots.values():
            if not robot.spec.names.namespace:
                robot.report(status)
