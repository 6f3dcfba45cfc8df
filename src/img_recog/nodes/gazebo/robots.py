"""The robots of the simulation with all that belongs to them, added and removed while it runs."""
import threading
from functools import partial
from typing import Any, Callable, Collection, Dict, List, NamedTuple, Optional, Sequence, Tuple

import rospy
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.conversions.sensor_table import SENSORS
from img_recog.errors import SimulationError, UserError, one_line
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.lockstep import Lockstep
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.robot_plans import RobotPlan, RobotPlans
from img_recog.nodes.gazebo.robot_topics import RobotTopics, SensorTopics, Transforms
from img_recog.nodes.gazebo.static_transforms import StaticTransforms
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.simulation import assembly
from img_recog.simulation.carrier import Carrier, Reading
from img_recog.simulation.models import Models
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle

WORLD_FRAME = 'world'
_TAKEN = '/clock', '/tf', '/tf_static', '/rosout', '/rosout_agg', '/diagnostics'


class _Connected(NamedTuple):
    """A robot with its topics."""

    plan: RobotPlan
    vehicle: Vehicle
    topics: RobotTopics


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
        self._robots: Dict[str, _Connected] = {}
        # of models that do not drive
        self._sensors: Dict[str, Tuple[RobotPlan, SensorTopics]] = {}

    def add(self, plan: RobotPlan) -> None:
        """Add a robot, apart from the others and the walls, and log its warnings.

        Raises a UserError when that cannot be; nothing has changed then.
        """
        if plan.name in self._models.names:
            raise SimulationError('there is a model {} already'.format(plan.name),
                                  'give another name')
        self._check_namespace(plan)
        warnings = assembly.add_robot_apart(self._simulator, plan.source, plan.settings,
                                            plan.has_place)
        vehicle = self._simulator.vehicles[-1]
        try:
            self.connect(vehicle, plan)
        except UserError:
            self._simulator.remove(vehicle)
            raise
        self._models.add_vehicle(vehicle)
        for warning in (*plan.source.warnings, *warnings):
            rospy.logwarn('%s: %s', plan.names.words, warning)
        rospy.loginfo('added %s: %.4f kg with root link %s', plan.names.words,
                      vehicle.robot.mass(), vehicle.robot.root)
        self.log_start(plan.name)

    def _check_namespace(self, plan: RobotPlan) -> None:
        if any(each.plan.names.namespace == plan.names.namespace
               for each in self._robots.values()):
            raise SimulationError('there is a robot with the namespace {!r} already'.format(
                plan.names.namespace), 'give it another robot_namespace')

    def _check_topics(self, plan: RobotPlan) -> None:
        """Raise SimulationError if a topic would be that of two sensors, or of something else."""
        own, command, others = plan.published(), plan.command_topic, list(self._robots.values())
        plans = [*(robot.plan for robot in others), *(each for each, _ in self._sensors.values())]
        published = {topic for each in plans for topic in each.published()}
        for topic in own:
            if own.count(topic) > 1 or topic in published:
                raise SimulationError('two sensors are on the topic {}'.format(topic),
                                      'give each another topic')
        commands = {command, *(robot.plan.command_topic for robot in others)}
        for topic in (*own, command):
            if topic in _TAKEN:
                raise SimulationError('the topic {} is not that of a robot'.format(topic),
                                      'give its plugin another one')
            if topic in commands and topic in {*own, *published}:
                raise SimulationError('a sensor and commands are on the topic {}'.format(topic),
                                      'give each another topic')

    def log_start(self, name: str) -> None:
        """Log where a robot starts."""
        robot = self._robots[name]
        spawn = robot.vehicle.settings.spawn
        rospy.loginfo('%s is at the start: x %.2f m, y %.2f m, yaw %.2f rad',
                      robot.plan.names.words, spawn.x_pos, spawn.y_pos, spawn.yaw)

    def connect(self, vehicle: Vehicle, plan: RobotPlan) -> None:
        """Give a robot of the simulator its topics.

        Raises a UserError when two sensors have the same topic, or those of its cameras cannot be
        used.
        """
        self._images.check_cameras(plan.cameras, plan.names)
        self._check_topics(plan)
        names, odometry, name = plan.names, vehicle.odometry, vehicle.robot.name
        vehicle.drive.scale_timeout(self._timeout_scale)
        self._images.add_cameras(vehicle, plan.cameras, names)
        self._robots[name] = _Connected(
            plan, vehicle, RobotTopics(vehicle, names, self._transforms, self._calls,
                                       self._lockstep))
        if self._world_tf and names.namespace and odometry.publish_odom_tf:
            self._statics.set('world of ' + name, [_transform(
                PlanePose(*vehicle.odometry_origin), WORLD_FRAME,
                names.frame(odometry.odom_frame))])
        self._add_diagnostics(name)

    def connect_model(self, carrier: Carrier, plan: RobotPlan) -> None:
        """Give a model of the world that drives or has sensors its topics.

        Where that cannot be, a line of the log says why, and it has none.
        """
        try:
            if isinstance(carrier, Vehicle):
                self._check_namespace(plan)
                self.connect(carrier, plan)
                return
            self._images.check_cameras(plan.cameras, plan.names)
            self._check_topics(plan)
            self._images.add_cameras(carrier, plan.cameras, plan.names)
        except UserError as error:
            rospy.logerr('model %s has no topics: %s', carrier.robot.name, one_line(error))
            return
        self._sensors[carrier.robot.name] = plan, SensorTopics(carrier, plan.names)

    def add_sensors(self, first: int) -> None:
        """Give sensors to the bodies of the world from a number on."""
        count = len(self._simulator.carriers)
        sources, warnings = assembly.add_sensors(self._simulator, SENSORS, first=first)
        for warning in warnings:
            rospy.logwarn('%s', warning)
        for carrier, source in zip(self._simulator.carriers[count:], sources):
            self.connect_model(carrier, RobotPlans.of_model(source, carrier.settings))

    def remove_sensors(self) -> None:
        """End the topics of sensors of models that are there no longer."""
        there = {carrier.robot.name for carrier in self._simulator.carriers}
        for name in set(self._sensors) - there:
            _, topics = self._sensors.pop(name)
            topics.close()
            self._images.remove_cameras(topics.carrier)

    def remove(self, name: str) -> None:
        """Remove a robot; SimulationError when there is none of that name."""
        if name not in self._robots:
            raise SimulationError('no robot {!r} (robots: {})'.format(
                name, ', '.join(self._robots) or 'none'))
        robot = self._robots.pop(name)
        if self._diagnostics is not None and robot.plan.names.namespace:
            self._diagnostics.remove(name)
        robot.topics.close()
        if self._lockstep is not None and robot.plan.names.namespace:
            self._lockstep.forget(robot.plan.names.namespace)
        self._statics.remove('world of ' + name)
        self._images.remove_cameras(robot.vehicle)
        self._models.remove_vehicle(robot.vehicle)
        self._simulator.remove(robot.vehicle)
        rospy.loginfo('%s was removed', robot.plan.names.words)

    def __contains__(self, name: str) -> bool:
        return name in self._robots

    def apply_commands(self) -> None:
        """Apply the newest commands."""
        for robot in self._robots.values():
            robot.topics.apply_command()

    def disable_unused(self) -> None:
        """Disable the sensors that have no subscriber."""
        for robot in self._robots.values():
            robot.topics.disable_unused()
        for _, topics in self._sensors.values():
            topics.disable_unused()

    def namespaces(self, names: Optional[Collection[str]] = None) -> List[str]:
        """Return the namespaces of the robots with some names, or of all."""
        return [robot.plan.names.namespace for name, robot in self._robots.items()
                if names is None or name in names]

    def discard_commands(self) -> None:
        """Drop commands that were not applied yet."""
        for robot in self._robots.values():
            robot.topics.discard_command()

    def publish(self, readings: Sequence[Reading]) -> None:
        """Publish the readings of all sensors but cameras."""
        found: Dict[str, List[Reading]] = {name: [] for name in (*self._robots, *self._sensors)}
        for reading in readings:
            if not self._images.is_camera(reading):
                found[reading.robot].append(reading)
        for name, robot in self._robots.items():
            robot.topics.publish(found[name])
        for name, (_, topics) in self._sensors.items():
            topics.publish(found[name])
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
        if self._diagnostics is not None and robot.plan.names.namespace:
            self._diagnostics.add(name, robot.topics.report)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add the robot without a namespace to a status; to be called once in each period."""
        for robot in list(self._robots.values()):
            if not robot.plan.names.namespace:
                robot.topics.report(status)


class RobotUpdates:
    """Makes the robots those of ~robots, also by the service ~update_robots (std_srvs/Trigger).

    A robot that fails does not keep the others from being there. The message of the response has a
    line for each one that fails: NAME: REASON.
    """

    def __init__(self, robots: Robots, plans: RobotPlans, calls: ServiceCalls):
        """Add the robots and advertise; the loop must not run yet."""
        self._robots, self._plans, self._calls = robots, plans, calls
        self._made: Dict[str, Tuple[Any, ...]] = {}     # from what each robot was made
        self._said: Dict[str, str] = {}                 # why a robot is not there
        self._lock = threading.Lock()
        self._update(lambda action: action())
        rospy.Service('~update_robots', Trigger, self._serve)

    def _serve(self, _: TriggerRequest) -> TriggerResponse:
        try:
            with self._lock:
                problems = self._update(self._calls.call)
        except UserError as error:
            return TriggerResponse(False, one_line(error))
        return TriggerResponse(not problems, '\n'.join(problems))

    def _update(self, call: Callable[[Callable[[], None]], Any]) -> List[str]:
        """Add and remove; return the problems. call: calls what simulates."""
        names = self._plans.names()
        problems = []
        for name in [name for name in self._made if name not in names] + names:
            try:
                if name in names:
                    self._make(name, call)
                else:
                    call(partial(self._remove, name))
                self._said.pop(name, None)
            except UserError as error:
                reason = one_line(error)
                problems.append('{}: {}'.format(name, reason))
                if self._said.get(name) != reason:
                    self._said[name] = reason
                    rospy.logerr('robot %s is not simulated: %s', name, reason)
        return problems

    def _make(self, name: str, call: Callable[[Callable[[], None]], Any]) -> None:
        snapshot = self._plans.snapshot(name)
        if self._made.get(name) == snapshot and name in self._robots:
            return
        plan = self._plans.named(name)      # before the one of that name is removed
        call(lambda: self._replace(plan, snapshot))

    def _replace(self, plan: RobotPlan, snapshot: Tuple[Any, ...]) -> None:
        """Add a robot; like `_remove` in what simulates, so that a late call is complete too."""
        if plan.name in self._made:
            self._remove(plan.name)
        self._robots.add(plan)
        self._made[plan.name] = snapshot

    def _remove(self, name: str) -> None:
        self._made.pop(name, None)
        if name in self._robots:
            self._robots.remove(name)


def _transform(pose: PlanePose, parent: str, child: str) -> TransformStamped:
    given = plane_msgs.pose_to_msg(pose, Header(frame_id=parent))
    return TransformStamped(given.header, child, Transform(
        Vector3(*pose[:2], 0.0), given.pose.orientation))
