"""The node turtlebot3_teleop_keyboard: drives the robot by the keys of a terminal.

Publishes cmd_vel (geometry_msgs/Twist) at 10 Hz, zeros while no key was pressed, and a last zero
on shutdown; /diagnostics (diagnostic_msgs/DiagnosticArray) at 1 Hz of wall time. Subscribes to
nothing. Serves ~yield (std_srvs/Trigger): publishes nothing for 0.5 s. Reads ~linear_step,
~angular_step, ~max_linear_velocity, ~max_angular_velocity (TeleopSettings).
"""
import contextlib
import os
import select
import sys
import termios
import time
import tty
from typing import Any, List, Optional

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.conversions import twist_msgs
from img_recog.processes import process_tree
from img_recog.ros import lifecycle, parameters
from img_recog.ros.diagnostics import EventCounter, NodeDiagnostics, add_counter
from img_recog.ros.stopping_publisher import StoppingPublisher
from img_recog.ros.yielding import Yielding
from img_recog.teleoperation import PERIOD_S, TeleopSettings, VelocityProfile

# set by launch files that start more than this node; a parameter would stay for the next teleop
_NO_KEYS = 'IMG_RECOG_NO_KEYS'
_HELP = ('w/x: faster forward/backward, a/d: faster to the left/right, s or space: stop, '
         'Ctrl-C: quit')
_NO_TERMINAL = ('no terminal to read keys from: publishing zeros; to drive the robot, run '
                'teleop_key.py in a separate terminal')


class Keyboard:
    """Reads keys without waiting for Enter; to be used in a `with` statement.

    present: whether keys can be read. If False, `key` only waits.

    Args:
        is_in_foreground: Whether the standard input is a terminal that has this process in its
            foreground. A process in the background would take the keys away from the shell.
    """

    def __init__(self, is_in_foreground: bool):
        self._stream = sys.stdin
        self._saved: Optional[List[Any]] = None
        self.present = is_in_foreground

    def __enter__(self) -> 'Keyboard':
        if self.present:
            self._saved = termios.tcgetattr(self._stream)
            tty.setcbreak(self._stream.fileno())
        return self

    def __exit__(self, *_):
        if self._saved is not None:
            # the terminal may have been closed
            with contextlib.suppress(termios.error):
                termios.tcsetattr(self._stream, termios.TCSADRAIN, self._saved)
            self._saved = None

    def key(self, timeout_s: float) -> Optional[str]:
        """Return the next key, None if none is pressed within `timeout_s`."""
        if not self.present:
            time.sleep(timeout_s)
            return None
        readable, _, _ = select.select([self._stream], [], [], timeout_s)
        if not readable:
            return None
        # not by sys.stdin.read: it buffers keys, which select then does not report
        try:
            pressed = os.read(self._stream.fileno(), 1)
        except OSError:
            pressed = b''
        self.present = bool(pressed)        # no byte or an error: it is closed
        return pressed.decode('ascii', 'replace') or None


class TeleopKey:
    """Publishes the command of a velocity profile at 10 Hz of wall time."""

    def __init__(self):
        settings = parameters.read(TeleopSettings)
        parameters.warn_of_unknown(TeleopSettings)
        self._profile = VelocityProfile(settings)
        self._velocity = StoppingPublisher('cmd_vel')
        self._sent, self._keys, self._has_terminal = EventCounter(), EventCounter(), False
        self._yielding = Yielding(self._reason_to_drive)
        NodeDiagnostics('teleop', 'none', self._report)

    def spin(self) -> None:
        """Read keys and publish commands until the node is shut down."""
        with Keyboard(_NO_KEYS not in os.environ
                      and process_tree.in_foreground(sys.stdin)) as keyboard:
            self._has_terminal = keyboard.present
            rospy.loginfo(_HELP if keyboard.present else _NO_TERMINAL)
            deadline = time.monotonic()
            while not rospy.is_shutdown():
                self._publish(*self._profile.tick())
                deadline = max(deadline + PERIOD_S, time.monotonic())
                self._handle_keys(keyboard, deadline)

    def _handle_keys(self, keyboard: Keyboard, deadline: float) -> None:
        remaining = deadline - time.monotonic()
        while remaining > 0 and not rospy.is_shutdown():
            key = keyboard.key(remaining)
            if key is not None:
                self._keys.add()
            if key is not None and self._profile.press(key):
                rospy.loginfo('target: linear %.2f m/s, angular %.2f rad/s',
                              self._profile.target_linear, self._profile.target_angular)
            remaining = deadline - time.monotonic()

    def _publish(self, linear: float, angular: float) -> None:
        if not self._yielding.is_active():
            self._velocity.publish(twist_msgs.to_msg(linear, angular))
            self._sent.add()

    def _reason_to_drive(self) -> str:
        profile = self._profile
        return ('the robot is driven by the keys of a terminal; press s there'
                if profile.target_linear or profile.target_angular else '')

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status of /diagnostics; runs in its thread."""
        subscribers = self._velocity.get_num_connections()
        if subscribers:
            status.summary(DiagnosticStatus.OK, 'reading keys' if self._has_terminal
                           else 'no terminal: publishing zeros')
        else:
            status.summary(DiagnosticStatus.WARN, 'nobody subscribes to {}: start the simulator '
                           'or the robot'.format(rospy.resolve_name('cmd_vel')))
        add_counter(status, 'commands', self._sent)
        status.add('subscribers', str(subscribers))
        status.add('keys', str(self._keys.total))
        status.add('target linear (m/s)', '{:.2f}'.format(self._profile.target_linear))
        status.add('target angular (rad/s)', '{:.2f}'.format(self._profile.target_angular))


def main() -> int:
    """Run the node; return its exit code."""
    return lifecycle.run('turtlebot3_teleop_keyboard', lambda: TeleopKey().spin(),
                         {'~': (TeleopSettings,)})
