"""Limits on how often something is done or logged."""
import math
import time
from typing import Callable, Dict, Optional

import rospy

from img_recog.errors import MAX_LINE, shortened


class Throttle:
    """Lets something happen at most once in `period_s` of wall time.

    rospy's own throttles use simulated time, which may stand still or run many times as fast.
    """

    def __init__(self, period_s: float, now: Callable[[], float] = time.monotonic):
        self._period_s, self._now = period_s, now
        self._last = -math.inf

    def ready(self, now_s: Optional[float] = None) -> bool:
        """Return True at most once in each period, and when time has gone back.

        now_s: the time, for another than that of the wall.
        """
        if now_s is None:
            now_s = self._now()
        if 0 <= now_s - self._last < self._period_s:
            return False
        self._last = now_s
        return True


class ChangeThrottle:
    """Decides which of many lines about a changing state the terminal shows.

    The first line is shown. After that, a line is shown if its state differs from the state shown
    last, and at least `period_s` seconds of wall time have passed since then.
    """

    def __init__(self, period_s: float, now: Callable[[], float] = time.monotonic):
        self._throttle, self._shown = Throttle(period_s, now), object()

    def shows(self, state: object) -> bool:
        """Return whether to show a line about `state`."""
        if state == self._shown or not self._throttle.ready():
            return False
        self._shown = state
        return True


class ThrottledWarning:
    """Logs each warning at most once in five seconds, and at most three different ones."""

    _PERIOD_S, _MAX_LINES = 5.0, 3

    def __init__(self, now: Callable[[], float] = time.monotonic,
                 log: Callable[[str, str], None] = rospy.logwarn):
        self._now, self._log = now, log
        self._logged: Dict[str, float] = {}         # when, by line

    def __call__(self, text: str, *values) -> None:
        line, now = shortened(text % values, MAX_LINE), self._now()
        self._logged = {other: then for other, then in self._logged.items()
                        if now - then < self._PERIOD_S}
        if line not in self._logged and len(self._logged) < self._MAX_LINES:
            self._logged[line] = now
            self._log('%s', line)
