"""The node gazebo: the TurtleBot3 burger in its world, simulated by PyBullet.

Subscribes: cmd_vel (geometry_msgs/Twist; the last one holds until the next).
Publishes: /clock (rosgraph_msgs/Clock, 100 Hz of simulated time), odom (nav_msgs/Odometry, frame
odom, child base_footprint, 30 Hz), tf odom -> base_footprint (30 Hz), joint_states
(sensor_msgs/JointState, 30 Hz), imu (sensor_msgs/Imu, frame imu_link, 200 Hz), scan
(sensor_msgs/LaserScan, frame base_scan, 5 Hz).
Serves: ~pause_physics, ~unpause_physics, ~reset_world, ~reset_simulation (std_srvs/Empty).
Reads: robot_description, and the fields of all settings of the simulation as private parameters.
"""
import dataclasses
import os
import time

import rospkg
import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_srvs.srv import Empty, EmptyResponse

from img_recog.nodes import (parameters, robot_msgs, running, sensing_msgs, twist_msgs,
                             user_paths)
from img_recog.nodes.slots import Newest, Requests
from img_recog.simulation import description, world
from img_recog.simulation.motion_state import MotionState
from img_recog.simulation.pacing import RealTimePacer
from img_recog.simulation.settings import SimulatorSettings, WindowSettings, whole_steps
from img_recog.simulation.simulator import Reading, Simulator
from img_recog.simulation.viewer import Viewer

_ODOM_FRAME = 'odom'
_WARNING_PERIOD_S = 5.0
_LOOK_UP_S = 0.1
_SERVICE_TIMEOUT_S = 5.0


class PybulletSim:
    """Steps the simulation in one loop; callbacks and services leave their wishes for it."""

    def __init__(self):
        settings = parameters.read_group(SimulatorSettings)
        window = parameters.read(WindowSettings)
        parameters.warn_of_unknown(WindowSettings, *map(type, vars(settings).values()))
        physics, self._scan, self._imu = settings.physics, settings.scan, settings.imu
        self._clock_period_s = physics.clock_period_s
        self._clock_steps = whole_steps('clock_period_s', physics.clock_period_s, physics.step_s)
        robot, worlds = description.parse(parameters.robot_description()), _worlds()
        self._root = robot.root
        settings = dataclasses.replace(settings, physics=dataclasses.replace(
            physics, world=user_paths.found(physics.world, but=('empty', *worlds))))
        self._simulator = Simulator(robot, worlds, world.connect(), settings)
        self._viewer = Viewer(robot, worlds, settings) if window.gui else None
        self._pacer = RealTimePacer(physics.real_time_factor)
        self._motion_state = MotionState()
        self._paused = False
        self._commands, self._requests = Newest(), Requests()
        self._advertise()
        rospy.loginfo('simulating %.4f kg with root link %s in world %s',
                      self._simulator.robot.mass(), robot.root, physics.world)

    def spin(self) -> None:
        """Simulate until the node is shut down."""
        while not rospy.is_shutdown():
            if self._paused:
                self._requests.serve(_LOOK_UP_S)
                self._pacer.restart()
            else:
                self._advance()
                self._wait(self._pacer.delay_s(self._clock_period_s))
            self._warn_if_late()
            self._update_window()
        if self._viewer is not None:
            self._viewer.close()

    def _wait(self, delay_s: float) -> None:
        """Serve requests until the next piece of time is due; look up at least ten times a second.
        """
        due = time.monotonic() + delay_s
        self._requests.serve(min(delay_s, _LOOK_UP_S))
        while time.monotonic() < due and not rospy.is_shutdown():
            self._requests.serve(min(due - time.monotonic(), _LOOK_UP_S))

    def _advertise(self) -> None:
        self._clock = rospy.Publisher('/clock', Clock, queue_size=100, latch=True)
        self._odometry = rospy.Publisher('odom', Odometry, queue_size=10)
        self._joint_states = rospy.Publisher('joint_states', JointState, queue_size=10)
        self._transforms = tf2_ros.TransformBroadcaster()
        self._imus = rospy.Publisher('imu', Imu, queue_size=100)
        self._scans = rospy.Publisher('scan', LaserScan, queue_size=10)
        self._publish = {'odometry': self._publish_odometry,
                         'joint_states': self._publish_joint_states,
                         'imu': self._publish_imu, 'scan': self._publish_scan}
        rospy.Subscriber('cmd_vel', Twist, self._keep_command, queue_size=10, tcp_nodelay=True)
        for name, action in (('pause_physics', self._pause), ('unpause_physics', self._unpause),
                             ('reset_world', self._reset_world),
                             ('reset_simulation', self._reset_simulation)):
            rospy.Service('~' + name, Empty, self._handler(name, action))

    def _handler(self, name, action):
        def handle(_):
            if not self._requests.do(action, _SERVICE_TIMEOUT_S):
                raise rospy.ServiceException(name + ': the simulation does not answer')
            return EmptyResponse()
        return handle

    def _pause(self) -> None:
        self._paused = True

    def _unpause(self) -> None:
        self._paused = False

    def _reset_world(self) -> None:
        self._commands.take()       # one from before the reset is not for after it
        self._simulator.reset_world()

    def _reset_simulation(self) -> None:
        self._commands.take()
        self._simulator.reset_simulation()
        # told at once: while the physics is paused no step would do so
        self._publish_clock()

    def _keep_command(self, msg: Twist) -> None:
        try:
            self._commands.put(twist_msgs.from_msg(msg))
        except twist_msgs.TwistError as error:
            rospy.logwarn_throttle(_WARNING_PERIOD_S, 'cmd_vel ignored: {}'.format(error))

    def _advance(self) -> None:
        command = self._commands.take()
        if command is not None:
            self._simulator.command(*command)
        readings = self._simulator.advance(self._clock_steps)
        # the clock first, so that no sensor is ahead of it
        self._publish_clock()
        for reading in readings:
            self._publish[reading.sensor](reading)

    def _publish_clock(self) -> None:
        self._clock.publish(Clock(robot_msgs.stamp_of(self._simulator.time_s)))

    def _publish_odometry(self, reading: Reading) -> None:
        msg = robot_msgs.odometry_to_msg(reading.value, robot_msgs.stamp_of(reading.time_s),
                                         _ODOM_FRAME, self._root)
        self._odometry.publish(msg)
        self._transforms.sendTransform(robot_msgs.transform_of(msg))
        news = self._motion_state.update(reading.value)
        if news is not None:
            rospy.loginfo('the robot %s, at x %.2f m, y %.2f m', news, *reading.value.position[:2])

    def _publish_joint_states(self, reading: Reading) -> None:
        self._joint_states.publish(robot_msgs.joint_states_to_msg(
            reading.value, robot_msgs.stamp_of(reading.time_s)))

    def _publish_imu(self, reading: Reading) -> None:
        self._imus.publish(sensing_msgs.imu_to_msg(
            reading.value, robot_msgs.stamp_of(reading.time_s), self._imu))

    def _publish_scan(self, reading: Reading) -> None:
        self._scans.publish(sensing_msgs.scan_to_msg(
            reading.value, robot_msgs.stamp_of(reading.time_s), self._scan))

    def _warn_if_late(self) -> None:
        if self._pacer.late:
            self._pacer.late = False
            rospy.logwarn_throttle(
                _WARNING_PERIOD_S, 'this machine is too slow for the real_time_factor asked for: '
                                   'simulated time falls behind, no step is skipped')

    def _update_window(self) -> None:
        if self._viewer is None:
            return
        gone = self._viewer.show(self._simulator.robot.pose())
        if gone is not None:
            rospy.logwarn('no window: %s; the simulation goes on without', gone)
            self._viewer = None


def _worlds() -> dict:
    folder = os.path.join(rospkg.RosPack().get_path('img_recog'), 'urdf')
    return {'turtlebot3_world': os.path.join(folder, 'turtlebot3_world.urdf')}


def main() -> int:
    """Run the node; return its exit code."""
    return running.run('gazebo', lambda: PybulletSim().spin())
