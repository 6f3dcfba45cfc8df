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
    """Logs each warning at most every five seconds, and three different ones in that time."""

    _PERIOD_S, _MOST = 5.0, 3

    def __init__(self, now: Callable[[], float] = time.monotonic,
                 log: Callable[[str, str], None] = rospy.logwarn):
        self._now, self._log = now, log
        self._logged = {}           # when each of the last ones was

    def __call__(self, text: str, *values) -> None:
        line, now = text % values, self._now()
        self._logged = {other: then for other, then in self._logged.items()
                        if now - then < self._PERIOD_S}
        if line not in self._logged and len(self._logged) < self._MOST:
            self._logged[line] = now
            self._log('%s', line)
