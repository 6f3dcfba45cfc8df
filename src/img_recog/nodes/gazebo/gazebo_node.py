"""The node gazebo: the TurtleBot3 burger in its world, simulated by PyBullet.

With several_robots it simulates those of the parameter ~robots: the topics of each are in the
namespace of its name, its ~set_pose is ~NAME/set_pose, and its frames begin with NAME/.

Subscribes: cmd_vel (geometry_msgs/Twist; a command holds until the next one), ~set_pose
(geometry_msgs/PoseStamped; moves the robot), and if gazebo_msgs is installed, ~set_model_state
(gazebo_msgs/ModelState) and ~set_link_state (gazebo_msgs/LinkState).
Publishes: what the sensors measure, each on its topic (conversions/sensor_table.py), /clock
(rosgraph_msgs/Clock, 100 Hz of simulated time), /tf odom -> base_footprint (30 Hz),
~real_time_factor (std_msgs/Float64, measured, 1 Hz of wall time), ~view/image_raw
(sensor_msgs/Image, rgb8, at most 10 Hz of wall time),
~model_states (gazebo_msgs/ModelStates, 100 Hz), ~link_states (gazebo_msgs/LinkStates, 100 Hz)
and, of each bumper, bumper_states (gazebo_msgs/ContactsState) if gazebo_msgs is installed,
/diagnostics (diagnostic_msgs/DiagnosticArray, 1 Hz of wall time), /tf_static (tf2_msgs/TFMessage)
for cameras.
~world_outlines (visualization_msgs/MarkerArray, latched: what stands in the world, from above).
Of each camera on the robot: camera/rgb/image_raw, camera/depth/image_raw (sensor_msgs/Image),
camera/rgb/image_raw/compressed (sensor_msgs/CompressedImage), camera/rgb/camera_info and
camera/depth/camera_info (sensor_msgs/CameraInfo), camera/depth/points (sensor_msgs/PointCloud2).
Serves: ~pause_physics, ~unpause_physics, ~reset_world, ~reset_simulation (std_srvs/Empty), ~step
(std_srvs/Trigger: goes on for ~step_period while paused),
~update_robots (std_srvs/Trigger; with several_robots: adds and removes robots), and if gazebo_msgs
is installed, ~get_model_state, ~set_model_state, ~set_link_state, ~spawn_sdf_model,
~spawn_urdf_model, ~delete_model, ~get_world_properties, ~get_physics_properties,
~set_physics_properties, ~get_link_state, ~get_link_properties, ~get_joint_properties,
~get_model_properties, ~set_model_configuration, ~apply_body_wrench, ~clear_body_wrenches,
~apply_joint_effort, ~clear_joint_forces (gazebo_msgs).
Served by dynamic_reconfigure (~set_parameters, ~parameter_descriptions, ~parameter_updates):
real_time_factor and view.
Reads: robot_description, NAME/robot_description, NAME/tf_prefix, ~robots, and the fields of all
settings of the simulation as private parameters.
"""
import time
from functools import partial
from typing import Callable, Optional, Tuple

import cv2
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import plane_msgs, robot_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.loading import assemble
from img_recog.nodes.gazebo import model_services
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.lockstep import Lockstep, LockstepSettings
from img_recog.nodes.gazebo.model_services import ModelServices
from img_recog.nodes.gazebo.model_topics import WORLD_FRAME, WorldTopics
from img_recog.nodes.gazebo.physics_services import (RuntimeSettings, ServiceCalls,
                                                     SteppingSettings, serve_physics, serve_step)
from img_recog.nodes.gazebo.robot_reader import (ROBOTS, RobotReader, RobotsSettings,
                                                 robot_settings_classes)
from img_recog.nodes.gazebo.robot_updates import RobotUpdates
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate, Wait
from img_recog.nodes.gazebo.transforms import StaticTransforms
from img_recog.ros import lifecycle, master_calls, parameters
from img_recog.ros.diagnostics import MIN_SHARE, Durations, NodeDiagnostics, add_durations
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.transport import own_time
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.simulation.models import Models
from img_recog.simulation.pacing import Pace, timeout_scale
from img_recog.simulation.pictures.footprints import footprints
from img_recog.simulation.simulation_settings import PhysicsSettings, ViewSettings, whole_steps
from img_recog.simulation.simulator import Simulator

_SETTINGS = (PhysicsSettings, ViewSettings, RobotsSettings, LockstepSettings, SteppingSettings,
             *robot_settings_classes())
_POLL_PERIOD_S = 0.1
# Of simulated time, between two looks at commands and services; it takes about 1 ms. After the
# physics, no code for messages is in the processor's cache: it gets there once in a round.
_FREE_RUN_ROUND_S = 0.02
_LOCKSTEP_ROUND_S = 1.0


class SimulatedClock:
    """Publishes /clock (rosgraph_msgs/Clock) and ~real_time_factor (std_msgs/Float64).

    Attributes:
        periods: Durations of the simulation of a clock period, without waiting.
    """

    def __init__(self, simulator: Simulator, pace: Pace, gate: TimeGate):
        """Advertise; log a warning if another node publishes /clock."""
        self._simulator, self._pace, self._gate = simulator, pace, gate
        self.periods = Durations()
        self._times, self._msg = DirectPublisher('/clock', Clock, latch=True), Clock()
        self._factors = rospy.Publisher('~real_time_factor', Float64, queue_size=1, latch=True)
        name = rospy.get_name()
        others = sorted(set(master_calls.calls().state().published.get('/clock', ())) - {name})
        if others:
            rospy.logwarn('/clock has another publisher, %s: two simulations mix up time, tf and '
                          'odometry; stop one of them', ', '.join(others))

    def add(self) -> None:
        """Set the time of this node, and let the next flush publish it."""
        # 0 after a reset would be no time: rosbag record would end
        now = self._msg.clock = robot_msgs.stamp_of(self._simulator.time_s or 1e-9)
        own_time.set_time(now)
        self._times.add(self._msg)

    def flush(self) -> None:
        """Publish the times that were added."""
        self._times.flush()

    def count(self, simulated_s: float) -> None:
        """Count simulated time; once a second publish the real time factor."""
        measured = self._pace.measure(simulated_s)
        if measured is not None:
            self._factors.publish(Float64(measured))
        is_slow = self._pace.take_report()
        if is_slow:
            rospy.logwarn('this machine is too slow for real_time_factor %g: simulated time falls '
                          'behind, no step is skipped; the factor is %.2f now',
                          self._pace.wanted, self._pace.measured)
        elif is_slow is not None:
            rospy.loginfo('simulated time keeps up again, the factor is %.2f', self._pace.measured)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in a status; to be called once in each period, in any thread."""
        status.summary(*_summary(self._pace, self._gate.is_paused))
        status.add('simulated time (s)', '{:.2f}'.format(self._simulator.time_s))
        status.add('real time factor', '{:.2f}'.format(self._pace.measured))
        status.add('wanted real time factor', '{:g}'.format(self._pace.wanted))
        add_durations(status, 'clock period', self.periods)


def _summary(pace: Pace, is_paused: bool) -> Tuple[int, str]:
    if is_paused:
        return DiagnosticStatus.OK, 'paused'
    if 0 < pace.measured < MIN_SHARE * pace.wanted:
        return DiagnosticStatus.WARN, (
            'too slow: real time factor {:.2f} instead of {:g}; use a smaller real_time_factor, '
            'or close windows'.format(pace.measured, pace.wanted))
    return DiagnosticStatus.OK, 'real time factor {:.2f}'.format(pace.measured)


class Gazebo:
    """Steps the simulation in one loop; callbacks and services leave their work for it."""

    def __init__(self) -> None:
        physics, view = parameters.read(PhysicsSettings), parameters.read(ViewSettings)
        which = parameters.read(RobotsSettings)
        lockstep, stepping = parameters.read(LockstepSettings), parameters.read(SteppingSettings)
        self._clock_steps = whole_steps('clock_period_s', physics.clock_period_s, physics.step_s)
        # in lockstep, nothing is to be looked at before the next answers
        round_s = _LOCKSTEP_ROUND_S if lockstep.topics else _FREE_RUN_ROUND_S
        self._free_run_periods = max(1, round(round_s / physics.clock_period_s))
        parameters.warn_of_unknown(*_SETTINGS, also_known=[ROBOTS[1:]])
        reader = RobotReader(physics.step_s)
        single = None if which.several_robots else reader.single()
        self._simulator = assemble.simulator(physics, [] if single is None else [single],
                                             with_sensors=True, with_drives=True)
        report = self._simulator.world.report
        for line in report.lines():
            rospy.logwarn('%s', line)
        report.listen(lambda line: rospy.logwarn('%s', line))
        self._pace = Pace(physics.real_time_factor)
        self._calls = ServiceCalls()
        self._gate = TimeGate(Mode.PAUSED if stepping.paused else Mode.RUNNING, self._calls.wake,
                              lockstep.lockstep_timeout if lockstep.topics else None)
        self._clock = SimulatedClock(self._simulator, self._pace, self._gate)
        serve_physics(self._calls, {
            'pause_physics': partial(self._gate.change, 'pause'),
            'unpause_physics': partial(self._gate.change, 'unpause'),
            'reset_world': partial(self._reset, self._simulator.reset_world),
            'reset_simulation': self._reset_simulation})
        self._lockstep = Lockstep(lockstep, self._gate, self._simulator)
        statics, models = StaticTransforms(), Models(self._simulator)
        self._images = Images(self._simulator, view, statics, self._gate, self._calls.wake,
                              self._lockstep.redelivery)
        self._topics = WorldTopics(self._simulator, models, self._images, statics, self._calls,
                                   which.world_tf, self._lockstep)
        self._scale_timeouts()
        frame, origin = WORLD_FRAME, PlanePose(0.0, 0.0, 0.0)
        of_world = self._simulator.models
        if single is None:
            RobotUpdates(self._topics, reader, self._calls)
        else:
            robot = self._simulator.robots[0]       # before those of the file of the world
            of_world.remove(robot)
            self._topics.connect(robot)
            frame, origin = robot.odometry.odom_frame, PlanePose(*robot.odometry_origin)
            self._lockstep.check(robot.mounted.kinds)
        for model in of_world:
            self._topics.connect_of_file(model)
        self._lockstep.subscribe()
        self._reconfigurable = Reconfigurable(
            RuntimeSettings(physics.real_time_factor, view.view),
            lambda settings: self._calls.call(lambda: self._configure(settings)))
        self._services: Optional[ModelServices] = None
        if model_services.MISSING:
            rospy.loginfo('model_states and the services of models are not offered, because %s',
                          model_services.MISSING)
        else:
            self._services = ModelServices(
                self._simulator, models, self._topics, reader, self._calls, self._pace, self._gate,
                lambda factor: self._reconfigurable.update_configuration(
                    {'real_time_factor': factor}))
        self._outlines = rospy.Publisher('~world_outlines', MarkerArray, queue_size=1, latch=True)
        self._outlines_frame = frame, origin
        self._publish_outlines()
        self._topics.use_diagnostics(NodeDiagnostics('simulation', 'none', self._report))
        if single is None:
            rospy.loginfo('simulating %d robots in world %s', len(self._simulator.robots),
                          physics.world)
        else:
            rospy.loginfo('simulating %.4f kg with root link %s in world %s',
                          robot.body.mass(), robot.body.root, physics.world)
            self._topics.log_start(robot)
        # last: who finds ~step takes it that all topics are there, like img_recog.testing
        serve_step(self._calls, self._simulator, self._gate)

    def spin(self) -> None:
        """Simulate until the node is shut down."""
        try:
            while not rospy.is_shutdown():
                self._show()
                self._run_once()
        finally:        # publishing fails if a topic is closed meanwhile
            self._gate.change('shut_down')
            self._images.close()

    def _run_once(self) -> None:
        """Let some time pass, if it may; otherwise process service calls."""
        if self._gate.mode is not Mode.PAUSED:
            self._look()
        steps = self._simulator.steps
        if self._gate.may_pass(steps):
            simulated_s = self._advance(1 if self._pace.wanted else self._free_run_periods)
            self._clock.count(simulated_s)
            self._wait(self._pace.delay_s(simulated_s))
        elif self._gate.is_step_over(steps) and self._images.is_complete():
            self._gate.change('end_step')
        else:
            self._stand()

    def _look(self) -> None:
        """Tell the gate of what can only be asked for."""
        self._images.look()
        if self._lockstep.look():
            self._images.enable_cameras()
            self._lockstep.look_for_sensor()

    def _stand(self) -> None:
        """Process service calls while no time passes."""
        self._gate.report(self._simulator.time_s)
        self._calls.process(_POLL_PERIOD_S)
        if self._gate.is_paused or self._gate.awaited(Wait.LOADING):
            self._pace.restart()
        self._clock.count(0.0)

    def _advance(self, periods: int) -> float:
        """Simulate some clock periods and publish what the sensors measured in them.

        Returns the simulated time in s: less if a step by hand or the wait for others begins.
        """
        begin_s, begin = time.perf_counter(), self._simulator.steps
        if self._lockstep.take_due(self._topics.discard_commands):
            self._topics.apply_commands()
        self._topics.disable_unused()
        self._images.enable_cameras()
        end = self._lockstep.end_of(self._gate.end_of(
            (begin // self._clock_steps + periods) * self._clock_steps))
        readings = []
        while self._simulator.steps < end:
            steps = self._simulator.steps
            readings += self._simulator.advance(
                min(self._clock_steps - steps % self._clock_steps, end - steps))
            self._clock.add()
            if self._services is not None:
                self._services.update()
        if self._lockstep.is_on:
            self._images.wait_complete()
        # the clock first, so that no reading is stamped in the future
        self._clock.flush()
        self._lockstep.expect(readings, self._topics.namespaces)
        self._images.draw(readings, lambda: self._topics.publish(readings))
        self._clock.periods.add(
            (time.perf_counter() - begin_s) * self._clock_steps / (end - begin))
        return (end - begin) * self._simulator.world.step_s

    def _wait(self, delay_s: float) -> None:
        """Process service calls for `delay_s`, or until shutdown, checked each _POLL_PERIOD_S."""
        due, wanted = time.monotonic() + delay_s, self._pace.wanted
        self._calls.process(min(delay_s, _POLL_PERIOD_S))
        # ended by another real_time_factor
        while (time.monotonic() < due and self._pace.wanted == wanted
               and not rospy.is_shutdown()):
            self._show()
            self._calls.process(min(due - time.monotonic(), _POLL_PERIOD_S))

    def _show(self) -> None:
        """Show what was added or rearranged; draw the view and the window, if they are due."""
        if self._images.update_scene():
            self._pace.disturb()
            self._publish_outlines()
        self._images.update_view()
        self._images.update_window()

    def _publish_outlines(self) -> None:
        frame, origin = self._outlines_frame
        self._outlines.publish(plane_msgs.outlines_to_msg(
            footprints(self._simulator.world), origin, frame,
            robot_msgs.stamp_of(self._simulator.time_s)))

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status of /diagnostics; runs in its thread and only reads."""
        self._clock.report(status)
        self._calls.report(status)
        self._topics.report(status)
        self._images.report(status)

    def _configure(self, settings: RuntimeSettings) -> None:
        """Apply settings that were changed while the simulation runs."""
        self._images.set_view(settings.view)
        factor = settings.real_time_factor
        if factor != self._pace.wanted:
            self._pace.set_wanted(factor)
            self._scale_timeouts()

    def _scale_timeouts(self) -> None:
        if not self._lockstep.is_on:        # else commands come in simulated time
            self._topics.scale_timeouts(timeout_scale(self._pace.wanted))

    def _reset(self, reset: Callable[[], None]) -> None:
        self._topics.discard_commands()
        self._lockstep.notify_reset()
        reset()

    def _reset_simulation(self) -> None:
        self._reset(self._simulator.reset_simulation)
        self._gate.change('end_step')
        # at once: while the physics is paused, no step publishes it
        self._clock.add()
        self._clock.flush()


def main() -> int:
    """Run the node; return its exit code."""
    # the threads of OpenCV wait in a busy loop, which costs more CPU time than they save
    cv2.setNumThreads(1)
    return lifecycle.run(
        'gazebo', lambda: Gazebo().spin(),
        {'~': _SETTINGS}, source_of_time=True)
