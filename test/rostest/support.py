"""What the rostests share: waiting for conditions and collecting messages."""
import threading
import time

import rospy

DEADLINE_S = 60.0           # wall time, generous: the machine may be busy
_POLL = threading.Event()   # never set; waiting on it is how a poll passes the time


def wait_for(condition, what, deadline_s=DEADLINE_S):
    """Return the first true value of `condition()`; fail naming `what` after the deadline."""
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        _POLL.wait(0.02)
    raise AssertionError('waited {} s in vain for {}'.format(deadline_s, what))


class Recorder:
    """Collects the messages of a topic; `messages` may be read while it grows."""

    def __init__(self, topic, message_type, accept=lambda msg: True):
        self.messages = []
        self._topic = topic
        self._accept = accept
        rospy.Subscriber(topic, message_type, self._take, queue_size=1000, buff_size=1 << 26,
                         tcp_nodelay=True)

    def _take(self, msg):
        if self._accept(msg):
            self.messages.append(msg)

    def wait(self, count=1, deadline_s=DEADLINE_S):
        """Return the messages once there are `count` more than now."""
        goal = len(self.messages) + count
        wait_for(lambda: len(self.messages) >= goal,
                 '{} messages on {}'.format(count, self._topic), deadline_s)
        return self.messages


def from_node(name):
    """Return a filter for messages that the node of this name sent."""
    return lambda msg: msg._connection_header['callerid'] == name
