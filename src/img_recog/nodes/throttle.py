"""Warnings that would otherwise come with every message."""
import time
from typing import Callable

import rospy


class Throttle:
    """Lets something happen at most once in `period_s` of wall time.

    rospy's own throttles count simulated time, which may stand or run a thousand times as fast.
    """

    def __init__(self, period_s: float, now: Callable[[], float] = time.monotonic):
        self._period_s, self._now = period_s, now
        self._next = now()

    def ready(self) -> bool:
        """Return whether it is time again; if so, it is not for another period."""
        now = self._now()
        if now < self._next:
            return False
        self._next = now + self._period_s
        return True


class ThrottledWarning:
    """Logs a warning at most every five seconds."""

    def __init__(self):
        self._throttle = Throttle(5.0)

    def __call__(self, text: str, *values) -> None:
        if self._throttle.ready():
            rospy.logwarn(text, *values)
