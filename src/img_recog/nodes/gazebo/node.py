"""The node gazebo: the TurtleBot3 burger in its world, simulated by PyBullet.

Subscribes: cmd_vel (geometry_msgs/Twist; the last one holds until the next).
Publishes: /clock (rosgraph_msgs/Clock, 100 Hz of simulated time), odom (nav_msgs/Odometry, frame
odom, child base_footprint, 30 Hz), tf odom -> base_footprint (30 Hz), joint_states
(sensor_msgs/JointState, 30 Hz), imu (sensor_msgs/Imu, frame imu_link, 200 Hz), scan
(sensor_msgs/LaserScan, frame base_scan, 5 Hz), ~real_time_factor (std_msgs/Float64, as measured,
1 Hz of wall time), ~view/image_raw (sensor_msgs/Image, rgb8, at most 10 Hz of wall time),
~model_states (gazebo_msgs/ModelStates, 100 Hz) where gazebo_msgs is installed.
Serves: ~pause_physics, ~unpause_physics, ~reset_world, ~reset_simulation (std_srvs/Empty), and
~get_model_state, ~set_model_state (gazebo_msgs) where that is installed.
Reads: robot_description, and the fields of all settings of the simulation as private parameters.
"""
import time
from concurrent.futures import TimeoutError as LateError
from typing import Callable

import rosgraph
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
from std_srvs.srv import Empty, EmptyResponse

from img_recog import resources
from img_recog.conversions import robot_msgs
from img_recog.nodes.gazebo import model_services
from img_recog.nodes.gazebo.robot_topics import RobotTopics, TopicSettings
from img_recog.nodes.gazebo.view import ViewTopic
from img_recog.ros import lifecycle, parameters
from img_recog.ros.queues import CallQueue
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.simulation import description, gazebo_tags, loading, meshes, world_file
from img_recog.simulation.models import Models
from img_recog.simulation.pacing import RealTimeFactor, RealTimePacer
from img_recog.simulation.scene import Scene, poses_of
from img_recog.simulation.settings import PhysicsSettings, RobotSettings, ViewSettings, whole_steps
from img_recog.simulation.simulator import Simulator
from img_recog.simulation.vehicle import Vehicle
from img_recog.simulation.window import Window
from img_recog.simulation.world import World

_POLL_PERIOD_S = 0.1
_SERVICE_TIMEOUT_S = 5.0


class PybulletSim:
    """Steps the simulation in one loop; callbacks and services leave their wishes for it."""

    def __init__(self):
        physics, view = parameters.read(PhysicsSettings), parameters.read(ViewSettings)
        self._clock_period_s = physics.clock_period_s
        self._clock_steps = whole_steps('clock_period_s', physics.clock_period_s, physics.step_s)
        urdf = parameters.robot_description()
        robot = description.parse(urdf, resources.find)
        from_description = gazebo_tags.settings(urdf, physics.step_s)
        settings = parameters.read_group(RobotSettings, from_description)
        topics = parameters.read(TopicSettings, from_description)
        parameters.warn_of_unknown(PhysicsSettings, ViewSettings, TopicSettings,
                                   *map(type, vars(settings).values()))
        file = world_file.read(physics.world, resources.worlds(), resources.find)
        _warn_of_what_is_left_out(robot, urdf, file)

        client = loading.connect()
        world = World(physics, file, client)
        vehicle = Vehicle(robot, settings, physics.step_s, client)
        self._simulator = Simulator(world, [vehicle])
        scene = Scene([robot], file)
        self._window = Window(scene) if view.gui else None
        self._factor = RealTimeFactor()
        self._wanted_factor = physics.real_time_factor
        self._pacer = RealTimePacer(physics.real_time_factor)
        self._paused = False
        self._requests, self._warn = CallQueue(), ThrottledWarning()
        self._advertise()
        self._view = ViewTopic(scene, view)
        self._topics = {vehicle.robot.name: RobotTopics(vehicle, topics)}
        self._warn_at_start(vehicle)
        rospy.loginfo('simulating %.4f kg with root link %s in world %s', vehicle.robot.mass(),
                      robot.root, physics.world)

    def _warn_at_start(self, vehicle: Vehicle) -> None:
        for sensor in vehicle.missing:
            rospy.logwarn('the robot goes without %s', sensor)
        for overlap in self._simulator.overlaps():
            rospy.logwarn('%s: the robot starts inside of what it will be thrown out of; set '
                          'x_pos, y_pos, z_pos', overlap)
        name = rospy.get_name()
        clocks = dict(rosgraph.Master(name).getSystemState()[0]).get('/clock', ())
        others = sorted(set(clocks) - {name})
        if others:
            rospy.logwarn('/clock has another publisher, %s: two simulations mix up time, tf and '
                          'odometry; end one of them', ', '.join(others))

    def _advertise(self) -> None:
        self._clock = DirectPublisher('/clock', Clock, latch=True)
        self._factors = rospy.Publisher('~real_time_factor', Float64, queue_size=1, latch=True)
        for name, action in (('pause_physics', self._pause), ('unpause_physics', self._unpause),
                             ('reset_world', self._reset_world),
                             ('reset_simulation', self._reset_simulation)):
            rospy.Service('~' + name, Empty, self._handler(name, action))
        self._gazebo = None
        if model_services.AVAILABLE:
            self._gazebo = model_services.GazeboInterface(
                Models(self._simulator), self._requests, lambda: self._simulator.time_s)
        else:
            rospy.loginfo('no gazebo_msgs installed: model_states, get_model_state and '
                          'set_model_state are not offered')

    def _handler(self, name: str, action: Callable[[], None]):
        def handle(_):
            try:
                self._requests.call(action, _SERVICE_TIMEOUT_S)
            except LateError:
                raise rospy.ServiceException(name + ': the simulation does not answer')
            return EmptyResponse()
        return handle

    def spin(self) -> None:
        """Simulate until the node is shut down."""
        while not rospy.is_shutdown():
            if self._paused:
                self._requests.process(_POLL_PERIOD_S)
                self._pacer.restart()
                self._measure(0.0)
            else:
                self._advance()
                self._measure(self._clock_period_s)
                self._wait(self._pacer.delay_s(self._clock_period_s))
            self._show()
        self._view.close()
        if self._window is not None:
            self._window.close()

    def _wait(self, delay_s: float) -> None:
        """Serve requests until the next piece of time is due; look up at least ten times a second.
        """
        due = time.monotonic() + delay_s
        self._requests.process(min(delay_s, _POLL_PERIOD_S))
        while time.monotonic() < due and not rospy.is_shutdown():
            self._requests.process(min(due - time.monotonic(), _POLL_PERIOD_S))

    def _advance(self) -> None:
        for topics in self._topics.values():
            topics.apply_command()
        readings = self._simulator.advance(self._clock_steps)
        # the clock first, so that no sensor is ahead of it
        self._publish_clock()
        for reading in readings:
            self._topics[reading.robot].publish(reading)
        if self._gazebo is not None:
            self._gazebo.update()

    def _publish_clock(self) -> None:
        now = robot_msgs.stamp_of(self._simulator.time_s)
        lifecycle.set_time(now)
        self._clock.publish(Clock(now))

    def _measure(self, simulated_s: float) -> None:
        measured = self._factor.update(simulated_s)
        if measured is not None:
            self._factors.publish(Float64(measured))
        if self._pacer.late and self._factor.last:
            self._pacer.late = False
            self._warn('this machine is too slow for real_time_factor %g: simulated time falls '
                       'behind, no step is skipped; at %.2f now', self._wanted_factor,
                       self._factor.last)

    def _show(self) -> None:
        self._view.update(self._simulator)
        if self._window is None or not self._window.due():
            return
        gone = self._window.show(poses_of(self._simulator))
        if gone is not None:
            rospy.logwarn('no window: %s; the simulation goes on without', gone)
            self._window = None

    def _pause(self) -> None:
        self._paused = True

    def _unpause(self) -> None:
        self._paused = False

    def _discard_commands(self) -> None:
        for topics in self._topics.values():
            topics.discard_command()

    def _reset_world(self) -> None:
        self._discard_commands()
        self._simulator.reset_world()

    def _reset_simulation(self) -> None:
        self._discard_commands()
        self._simulator.reset_simulation()
        # told at once: while the physics is paused no step would do so
        self._publish_clock()


def _warn_of_what_is_left_out(robot: description.Description, urdf: str,
                              file: world_file.WorldFile) -> None:
    if robot.missing_meshes:
        rospy.logwarn('robot_description: %s', meshes.described(robot.missing_meshes))
    strange = gazebo_tags.not_simulated(urdf)
    if strange:
        rospy.logwarn('robot_description: <gazebo> tags that this simulator has nothing for: %s',
                      ', '.join(strange))
    for warning in file.warnings:
        rospy.logwarn('%s', warning)


def main() -> int:
    """Run the node; return its exit code."""
    return lifecycle.run('gazebo', lambda: PybulletSim().spin(), source_of_time=True)
