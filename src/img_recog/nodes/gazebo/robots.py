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
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.simulation import assembly
from img_recog.simulation.carrier import Carrier, Reading
from img_recog.simulation.models import Models
from img_recog.simulation.robot_spec import RobotSpec
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle

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
        self._robots: Dict[str, RobotTopics] = {}
        self._sensors: Dict[str, SensorTopics] = {}     # of models that do not drive

    def add(self, spec: RobotSpec) -> None:
        """Add a robot, apart from the others and the walls, and log its warnings.

        Raises a UserError when that cannot be; nothing has changed then.
        """
        if spec.name in self._models.names:
            raise SimulationError('there is a model {} already'.format(spec.name),
                                  'give another name')
        self._check_namespace(spec)
        warnings = assembly.add_robot_apart(self._simulator, spec)
        vehicle = self._simulator.vehicles[-1]
        try:
            self.connect(vehicle, spec)
        except UserError:
            self._simulator.remove(vehicle)
            raise
        self._models.add_vehicle(vehicle)
        for warning in (*spec.warnings, *warnings):
            rospy.logwarn('%s: %s', spec.names.words, warning)
        rospy.loginfo('added %s: %.4f kg with root link %s', spec.names.words,
                      vehicle.robot.mass(), vehicle.robot.root)
        self.log_start(spec.name)

    def _check_namespace(self, spec: RobotSpec) -> None:
        if spec.names.namespace in self.namespaces():
            raise SimulationError('there is a robot with the namespace {!r} already'.format(
                spec.names.namespace), 'give it another robot_namespace')

    def log_start(self, name: str) -> None:
        """Log where a robot starts."""
        robot = self._robots[name]
        spawn = robot.vehicle.settings.spawn
        rospy.loginfo('%s is at the start: x %.2f m, y %.2f m, yaw %.2f rad',
                      robot.spec.names.words, spawn.x_pos, spawn.y_pos, spawn.yaw)

    def connect(self, carrier: Carrier, spec: RobotSpec) -> None:
        """Give a robot of the simulator, or a model with sensors, its topics.

        spec: with the names that others see. Raises a UserError when two sensors have the same
        topic, or those of its cameras cannot be used.
        """
        check_topics(spec, [each.spec for each in self._all()], rospy.resolve_name)
        self._images.add_cameras(carrier, spec.names)
        name = carrier.robot.name
        if not isinstance(carrier, Vehicle):
            self._sensors[name] = SensorTopics(carrier, spec)
            return
        carrier.drive.scale_timeout(self._timeout_scale)
        self._robots[name] = RobotTopics(carrier, spec, self._transforms, self._calls,
                                         self._lockstep)
        odometry = carrier.odometry
        if self._world_tf and spec.names.namespace and odometry.publish_odom_tf:
            self._statics.set('world of ' + name, [_transform(
                PlanePose(*carrier.odometry_origin), WORLD_FRAME,
                spec.names.frame(odometry.odom_frame))])
        self._add_diagnostics(name)

    def _all(self) -> List[SensorTopics]:
        return [*self._robots.values(), *self._sensors.values()]

    def connect_model(self, carrier: Carrier) -> None:
        """Give a model of the world that drives or has sensors its topics.

        Where that cannot be, a line of the log says why, and it has none.
        """
        spec = in_namespace(carrier.spec)
        try:
            if isinstance(carrier, Vehicle):
                self._check_namespace(spec)
            self.connect(carrier, spec)
        except UserError as error:
            rospy.logerr('model %s has no topics: %s', carrier.robot.name, one_line(error))

    def add_sensors(self, first: int) -> None:
        """Give sensors to the bodies of the world from a number on."""
        count = len(self._simulator.carriers)
        for warning in assembly.add_sensors(self._simulator, SENSORS, first=first):
            rospy.logwarn('%s', warning)
        for carrier in self._simulator.carriers[count:]:
            self.connect_model(carrier)

    def remove_sensors(self) -> None:
        """End the topics of sensors of models that are there no longer."""
        there = {carrier.robot.name for carrier in self._simulator.carriers}
        for name in set(self._sensors) - there:
            topics = self._sensors.pop(name)
            topics.close()
            self._images.remove_cameras(topics.carrier)

    def remove(self, name: str) -> None:
        """Remove a robot; SimulationError when there is none of that name."""
        if name not in self._robots:
            raise SimulationError('no robot {!r} (robots: {})'.format(
                name, ', '.join(self._robots) or 'none'))
        robot = self._robots.pop(name)
        if self._diagnostics is not None and robot.spec.names.namespace:
            self._diagnostics.remove(name)
        robot.close()
        if self._lockstep is not None and robot.spec.names.namespace:
            self._lockstep.forget(robot.spec.names.namespace)
        self._statics.remove('world of ' + name)
        self._images.remove_cameras(robot.vehicle)
        self._models.remove_vehicle(robot.vehicle)
        self._simulator.remove(robot.vehicle)
        rospy.loginfo('%s was removed', robot.spec.names.words)

    def __contains__(self, name: str) -> bool:
        return name in self._robots

    def apply_commands(self) -> None:
        """Apply the newest commands."""
        for robot in self._robots.values():
            robot.apply_command()

    def disable_unused(self) -> None:
        """Disable the sensors that have no subscriber."""
        for topics in self._all():
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
        found: Dict[str, List[Reading]] = {name: [] for name in (*self._robots, *self._sensors)}
        for reading in readings:
            if not self._images.is_camera(reading):
                found[reading.robot].append(reading)
        for topics in self._all():
            topics.publish(found[topics.carrier.robot.name])
        self._transforms.flush()

    def scale_timeouts(self, scale: float) -> None:
        """Make `cmd_vel_timeout` of all robots, also later ones, `scale` times as long."""
        self._timeout_scale = scale
        for robot in self._robots.values():
            robot.vehicle.drive.scale_timeout(scale)

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
