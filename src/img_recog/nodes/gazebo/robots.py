"""The robots of the simulation with all that belongs to them, added and removed while it runs."""
from typing import Collection, Dict, List, Optional, Sequence

import rospy
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from std_msgs.msg import Header

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.conversions.sensor_table import SENSORS
from img_recog.conversions.topic_checks import check_topics
from img_recog.errors import SimulationError, UserError, one_line
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.lockstep import Lockstep
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.robot_reader import in_namespace
from img_recog.nodes.gazebo.robot_topics import RobotTopics, SensorTopics, Transforms
from img_recog.nodes.gazebo.static_transforms import StaticTransforms
from img_recog.report import Report
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.simulation import assembly
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.models import Models
from img_recog.simulation.mounted_sensors import MountedSensors, Reading
from img_recog.simulation.simulated_model import Robot, SimulatedModel
from img_recog.simulation.simulator import Simulator

WORLD_FRAME = 'world'


class Robots:
    """The robots. All methods are for the thread that simulates, `report` for any.

    world_tf: whether static transforms from the world to the odometry frames of robots with a
    namespace are published. lockstep: see RobotTopics.
    """

    def __init__(self, simulator: Simulator, models: Models, images: Images,
                 statics: StaticTransforms, calls: ServiceCalls, world_tf: bool,
                 lockstep: Optional[Lockstep] = None):
        self._simulator, self._models, self._images = simulator, models, images
        self._statics, self._calls, self._world_tf = statics, calls, world_tf
        self._lockstep = lockstep
        self._diagnostics: Optional[NodeDiagnostics] = None
        self._transforms = Transforms()
        self._timeout_scale = 1.0
        self._topics: Dict[str, SensorTopics] = {}      # by the names of bodies

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
        world = self._simulator.world
        assembly.add_sensors(world, model, SENSORS, world.report)
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
            self._topics[name] = SensorTopics(mounted)
            return
        model.drive.scale_timeout(self._timeout_scale)
        self._topics[name] = RobotTopics(model, self._transforms, self._calls, self._lockstep)
        odometry = model.odometry
        if self._world_tf and spec.names.namespace and odometry.publish_odom_tf:
            self._statics.set('world of ' + name, [_transform(
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
            if isinstance(topics, RobotTopics):
                namespace = topics.spec.names.namespace
                if self._diagnostics is not None and namespace:
                    self._diagnostics.remove(mounted.body.name)
                if self._lockstep is not None and namespace:
                    self._lockstep.forget(namespace)
                self._statics.remove('world of ' + mounted.body.name)
                rospy.loginfo('%s was removed', topics.spec.names.words)

    @property
    def _robots(self) -> Dict[str, RobotTopics]:
        return {name: topics for name, topics in self._topics.items()
                if isinstance(topics, RobotTopics)}

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
        for robot in list(self._robots.values()):
            if not robot.spec.names.namespace:
                robot.report(status)


def _transform(pose: PlanePose, parent: str, child: str) -> TransformStamped:
    given = plane_msgs.pose_to_msg(pose, Header(frame_id=parent))
    return TransformStamped(given.header, child, Transform(
        Vector3(*pose[:2], 0.0), given.pose.orientation))
