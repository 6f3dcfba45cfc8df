"""Paces simulated time by real time, and measures the real time factor."""
import math
import time
from typing import Callable, Optional

# of wall time: with more delay the machine is too slow, and the delay is not caught up with
_MAX_DELAY_S = 0.5
_MEASURING_PERIOD_S = 1.0
_REPORT_PERIOD_S = 30.0     # of wall time, between two reports that the machine is too slow
_WORSE = 0.5


class RealTimePacer:
    """Computes how long to wait between two pieces of simulated time.

    late: whether simulated time has fallen behind; stays set until the user clears it.
    """

    def __init__(self, real_time_factor: float, now: Callable[[], float] = time.monotonic):
        self._factor = real_time_factor
        self._now = now
        self.late = False
        self.restart()

    def restart(self) -> None:
        """Start from now, as after a pause: the time until now is not caught up with."""
        self._due = self._now()

    def delay_s(self, simulated_s: float) -> float:
        """Return the wall seconds to wait after `simulated_s` more seconds were simulated."""
        if self._factor == 0:
            return 0.0
        self._due += simulated_s / self._factor
        delay_s = self._due - self._now()
        if delay_s < -_MAX_DELAY_S:
            self.late = True
            self.restart()
        return max(0.0, delay_s)


class RealTimeFactor:
    """Measures the simulated seconds per second of wall time.

    last: the newest measurement, 0 before the first.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now = now
        self._since, self._simulated_s = now(), 0.0
        self.last = 0.0

    def update(self, simulated_s: float) -> Optional[float]:
        """Count simulated time; return the factor once a second, else None."""
        self._simulated_s += simulated_s
        passed = self._now() - self._since
        if passed < _MEASURING_PERIOD_S:
            return None
        self.last = self._simulated_s / passed
        self._since, self._simulated_s = self._now(), 0.0
        return self.last


class SlowReports:
    """Decides when to report that the machine is too slow: first, when it gets worse, and rarely.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now = now
        self._last_s, self._last_factor = -math.inf, math.inf

    def ready(self, factor: float) -> bool:
        """Return whether to report this real time factor."""
        now = self._now()
        if now < self._last_s + _REPORT_PERIOD_S and factor > _WORSE * self._last_factor:
            return False
        self._last_s, self._last_factor = now, factor
        return True
