"""The node turtlebot3_teleop_keyboard: keys of a terminal to commands for a robot.

Publishes: cmd_vel (geometry_msgs/Twist, 10 Hz, always; zeros when idle and once at the end).
Subscribes to nothing. Reads: ~linear_step, ~angular_step, ~max_linear_velocity,
~max_angular_velocity (TeleopSettings).
"""
import threading
import time

import rospy
from geometry_msgs.msg import Twist

from img_recog.conversions import twist_msgs
from img_recog.ros import lifecycle, parameters
from img_recog.teleoperation.keyboard import Keyboard
from img_recog.teleoperation.profile import VelocityProfile
from img_recog.teleoperation.settings import TeleopSettings

_PERIOD_S = 0.1
_FLUSH_S = 0.1
_HELP = ('w/x: faster forward/backward, a/d: faster to the left/right, s or space: stop, '
         'Ctrl-C: end')


class TeleopKey:
    """Sends the command of a velocity profile at 10 Hz of wall time."""

    def __init__(self):
        settings = parameters.read(TeleopSettings)
        parameters.warn_of_unknown(TeleopSettings)
        self._profile = VelocityProfile(settings)
        self._velocity = rospy.Publisher('cmd_vel', Twist, queue_size=10)
        self._sending = threading.Lock()
        self._stopped = False
        lifecycle.on_shutdown(self._stop_robot)

    def spin(self) -> None:
        """Read keys and send commands until the node is shut down."""
        with Keyboard() as keyboard:
            rospy.loginfo(_HELP if keyboard.present else
                          'no terminal to read keys from: sending zeros; run teleop_key.py in a '
                          'terminal of its own to drive')
            deadline = time.monotonic()
            while not rospy.is_shutdown():
                self._send(*self._profile.tick())
                deadline = max(deadline + _PERIOD_S, time.monotonic())
                self._take_keys(keyboard, deadline)

    def _take_keys(self, keyboard: Keyboard, deadline: float) -> None:
        remaining = deadline - time.monotonic()
        while remaining > 0 and not rospy.is_shutdown():
            key = keyboard.key(remaining)
            if key is not None and self._profile.press(key):
                rospy.loginfo('target: linear %.2f m/s, angular %.2f rad/s',
                              self._profile.target_linear, self._profile.target_angular)
            remaining = deadline - time.monotonic()

    def _send(self, linear: float, angular: float) -> None:
        with self._sending:
            if not self._stopped:
                self._velocity.publish(twist_msgs.to_msg(linear, angular))

    def _stop_robot(self) -> None:
        with self._sending:
            self._stopped = True        # spin goes on until all shutdown hooks have run
            self._velocity.publish(twist_msgs.to_msg(0.0))
        # the publisher sends from a thread of its own, which the shutdown would cut off
        time.sleep(_FLUSH_S)


def main() -> int:
    """Run the node; return its exit code."""
    return lifecycle.run('turtlebot3_teleop_keyboard', lambda: TeleopKey().spin())
