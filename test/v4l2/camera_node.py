"""The node usb_cam under test: its program, topics, services, diagnostics and log."""
import pathlib
import re

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Empty

from img_recog_testing.waiting import wait_for

_ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = _ROOT / 'devel' / 'lib' / 'img_recog' / 'usb_cam_node.py'


class Topic:
    """Receives a topic; keeps the last message, and the stamps of all, in ns."""

    def __init__(self, name, msg_class):
        self.last, self.stamps = None, []
        self._subscriber = rospy.Subscriber(name, msg_class, self._receive)

    def _receive(self, msg):
        self.last = msg
        self.stamps.append(msg.header.stamp.to_nsec())

    def wait_more(self, count=1):
        """Wait for `count` more messages; return the last one."""
        before = len(self.stamps)
        wait_for(lambda: len(self.stamps) >= before + count,
                 '{} more messages of {}'.format(count, self._subscriber.name))
        return self.last

    def close(self):
        self._subscriber.unregister()


class Diagnostics:
    """Receives the status `usb_cam: camera` on /diagnostics."""

    def __init__(self):
        self.levels, self.message = [], ''
        rospy.Subscriber('/diagnostics', DiagnosticArray, self._receive)

    def _receive(self, array):
        for status in array.status:
            if status.name == 'usb_cam: camera':
                self.message = status.message
                self.levels.append(status.level)

    def wait(self, level, pattern, count=1):
        """Wait for `count` messages in a row with this level, the last one with the text.

        pattern: a regular expression. Returns the last message.
        """
        begin = len(self.levels)
        wait_for(lambda: len(self.levels) >= begin + count
                 and self.levels[-count:] == [level] * count
                 and re.search(pattern, self.message),
                 lambda: 'level {} on /diagnostics, got {} {}'.format(
                     level, self.levels[begin:], self.message))
        return self.message


def call(service):
    """Call a service of type std_srvs/Empty."""
    rospy.wait_for_service(service, 60)
    rospy.ServiceProxy(service, Empty)()


def log_lines(process, pattern):
    """Return the lines of a node's log that match a regular expression."""
    return [line for line in process.output.splitlines() if re.search(pattern, line)]


def time_of(line):
    """Return the wall time of a line of a log, in s."""
    return float(re.search(r'\] \[(\d+\.\d+)', line).group(1))


def intervals(stamps):
    """Return the seconds between stamps, which are in nanoseconds."""
    stamps = list(stamps)           # more may arrive in the meantime
    return [(b - a) / 1e9 for a, b in zip(stamps, stamps[1:])]


def range_text(intervals_s):
    """Return the range of some intervals as text."""
    return 'steps of {:.1f} to {:.1f} ms'.format(1000 * min(intervals_s), 1000 * max(intervals_s))
