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
from typing import Sequence, Union

import cv2
import rospy
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.conversions.plane_msgs import PlanePose
from img_recog.loading import assemble
from img_recog.nodes.gazebo import model_services
from img_recog.nodes.gazebo.clock import SimulatedClock
from img_recog.nodes.gazebo.images import Images
from img_recog.nodes.gazebo.link_services import LinkServices
from img_recog.nodes.gazebo.lockstep import Lockstep
from img_recog.nodes.gazebo.lockstep_settings import LockstepSettings
from img_recog.nodes.gazebo.model_services import ModelServices
from img_recog.nodes.gazebo.model_topics import WORLD_FRAME, WorldTopics
from img_recog.nodes.gazebo.outlines import Outlines
from img_recog.nodes.gazebo.physics_services import RuntimeSettings, ServiceCalls, serve_physics
from img_recog.nodes.gazebo.robot_reader import (ROBOTS, RobotReader, RobotsSettings,
                                                 robot_settings_classes)
from img_recog.nodes.gazebo.robot_updates import RobotUpdates
from img_recog.nodes.gazebo.simulation_diagnostics import SimulationDiagnostics
from img_recog.nodes.gazebo.stepping import Stepping, SteppingSettings
from img_recog.nodes.gazebo.transforms import StaticTransforms
from img_recog.nodes.gazebo.waiting import Waiting
from img_recog.ros import lifecycle, parameters
from img_recog.ros.diagnostics import NodeDiagnostics
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.simulation.models import Models
from img_recog.simulation.pacing import Pace, timeout_scale
from img_recog.simulation.simulation_settings import PhysicsSettings, ViewSettings, whole_steps

_POLL_PERIOD_S = 0.1
# Of simulated time, between two looks at commands and services; it takes about 1 ms. After the
# physics, no code for messages is in the processor's cache: it gets there once in a round.
_FREE_RUN_ROUND_S = 0.02
_LOCKSTEP_ROUND_S = 1.0


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
        parameters.warn_of_unknown(PhysicsSettings, ViewSettings, RobotsSettings,
                                   LockstepSettings, SteppingSettings,
                                   *robot_settings_classes(), also_known=[ROBOTS[1:]])
        reader = RobotReader(physics.step_s)
        single = None if which.several_robots else reader.single()
        self._simulator = assemble.simulator(physics, [] if single is None else [single],
                                             with_sensors=True, with_drives=True)
        report = self._simulator.world.report
        for line in report.lines():
            rospy.logwarn('%s', line)
        report.listen(lambda line: rospy.logwarn('%s', line))
        self._pace = Pace(physics.real_time_factor)
        if stepping.paused:
            self._pace.pause()
        self._clock = SimulatedClock(self._simulator, self._pace)
        self._calls = ServiceCalls()
        serve_physics(self._calls, {
            'pause_physics': self._pace.pause, 'unpause_physics': self._pace.unpause,
            'reset_world': self._reset_world, 'reset_simulation': self._reset_simulation})
        self._lockstep = Lockstep(lockstep, self._calls.wake) if lockstep.topics else None
        statics, models = StaticTransforms(), Models(self._simulator)
        self._images = Images(self._simulator, view, statics, lockstep=self._lockstep,
                              wake=self._calls.wake)
        self._topics = WorldTopics(self._simulator, models, self._images, statics, self._calls,
                                   which.world_tf, self._lockstep)
        if self._lockstep is None:      # else commands come in simulated time
            self._topics.scale_timeouts(timeout_scale(physics.real_time_factor))
        self._waiting = Waiting(self._simulator, self._images, self._topics, self._lockstep)
        frame, origin = WORLD_FRAME, PlanePose(0.0, 0.0, 0.0)
        of_world = self._simulator.models
        if single is None:
            RobotUpdates(self._topics, reader, self._calls)
        else:
            robot = self._simulator.robots[0]       # before those of the file of the world
            of_world.remove(robot)
            self._topics.connect(robot)
            frame, origin = robot.odometry.odom_frame, PlanePose(*robot.odometry_origin)
            if self._lockstep is not None:
                self._lockstep.check(robot.mounted.kinds)
        for model in of_world:
            self._topics.connect_of_file(model)
        if self._lockstep is not None:
            self._lockstep.subscribe()
        self._reconfigurable = Reconfigurable(
            RuntimeSettings(physics.real_time_factor, view.view),
            lambda settings: self._calls.call(lambda: self._configure(settings)))
        self._states: Sequence[Union[ModelServices, LinkServices]] = ()
        if model_services.MISSING:
            rospy.loginfo('model_states and the services of models are not offered, because %s',
                          model_services.MISSING)
        else:
            self._states = (
                ModelServices(self._simulator, models, self._topics, reader, self._calls,
                              self._pace, lambda factor: self._reconfigurable.
                              update_configuration({'real_time_factor': factor})),
                LinkServices(self._simulator, models, self._calls))
        self._outlines = Outlines(self._simulator, frame, origin)
        self._diagnostics = SimulationDiagnostics(self._pace, self._calls)
        self._topics.use_diagnostics(NodeDiagnostics('simulation', 'none', self._report))
        if single is None:
            rospy.loginfo('simulating %d robots in world %s', len(self._simulator.robots),
                          physics.world)
        else:
            rospy.loginfo('simulating %.4f kg with root link %s in world %s',
                          robot.body.mass(), robot.body.root, physics.world)
            self._topics.log_start(robot)
        # last: who finds ~step takes it that all topics are there, like img_recog.testing
        self._stepping = Stepping(self._calls, self._simulator, self._pace)

    def spin(self) -> None:
        """Simulate until the node is shut down."""
        try:
            while not rospy.is_shutdown():
                self._show()
                end = self._stepping.end
                is_paused = self._pace.is_paused and end is None
                if is_paused or self._waiting.must_stand():
                    self._calls.process(_POLL_PERIOD_S)
                    if self._pace.is_paused or self._images.is_loading():
                        self._pace.restart()
                    if is_paused:
                        self._waiting.restart()
                    self._clock.count(0.0)
                elif end is None or self._simulator.steps < end:
                    simulated_s = self._advance(1 if self._pace.wanted else self._free_run_periods)
                    self._clock.count(simulated_s)
                    self._wait(self._pace.delay_s(simulated_s))
                elif self._images.is_complete():
                    self._stepping.finish()
                else:
                    self._calls.process(_POLL_PERIOD_S)
        finally:        # publishing fails if a topic is closed meanwhile
            self._images.close()

    def _advance(self, periods: int) -> float:
        """Simulate some clock periods and publish what the sensors measured in them.

        Returns the simulated time in s: less if a step by hand or the wait for others begins.
        """
        begin_s, begin = time.perf_counter(), self._simulator.steps
        if self._waiting.take_commands():
            self._topics.apply_commands()
        self._topics.disable_unused()
        self._images.enable_cameras()
        end = (begin // self._clock_steps + periods) * self._clock_steps
        if self._stepping.end is not None:
            end = min(end, self._stepping.end)
        end = self._waiting.end_of(end)
        readings = []
        while self._simulator.steps < end:
            steps = self._simulator.steps
            readings += self._simulator.advance(
                min(self._clock_steps - steps % self._clock_steps, end - steps))
            self._clock.add()
            for states in self._states:
                states.update()
        self._waiting.finish()
        # the clock first, so that no reading is stamped in the future
        self._clock.flush()
        self._waiting.expect(readings)
        self._images.draw(readings, lambda: self._topics.publish(readings))
        self._diagnostics.steps.add(
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
            self._outlines.publish()
        self._images.update_view()
        self._images.update_window()

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status of /diagnostics; runs in its thread and only reads."""
        self._diagnostics.report(status, self._simulator.time_s)
        self._topics.report(status)
        self._images.report(status)

    def _configure(self, settings: RuntimeSettings) -> None:
        """Apply settings that were changed while the simulation runs."""
        self._images.set_view(settings.view)
        factor = settings.real_time_factor
        if factor != self._pace.wanted:
            self._pace.set_wanted(factor)
            if self._lockstep is None:      # else commands come in simulated time
                self._topics.scale_timeouts(timeout_scale(factor))

    def _reset_world(self) -> None:
        self._waiting.discard_commands()
        self._simulator.reset_world()

    def _reset_simulation(self) -> None:
        self._waiting.discard_commands()
        self._simulator.reset_simulation()
        self._stepping.finish()
        # at once: while the physics is paused, no step publishes it
        self._clock.add()
        self._clock.flush()


def main() -> int:
    """Run the node; return its exit code."""
    # the threads of OpenCV wait in a busy loop, which costs more CPU time than they save
    cv2.setNumThreads(1)
    return lifecycle.run(
        'gazebo', lambda: Gazebo().spin(),
        {'~': (PhysicsSettings, ViewSettings, RobotsSettings, LockstepSettings, SteppingSettings,
               *robot_settings_classes())}, source_of_time=True)
