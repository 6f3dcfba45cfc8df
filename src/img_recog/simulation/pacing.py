"""Holds simulated time to real time, and measures how well that goes."""
import time
from typing import Callable, Optional

# s of wall time: a machine that is later than this is too slow, and the difference is let go
_MAX_DELAY = 0.5
_MEASURING_S = 1.0


class RealTimePacer:
    """Says when the next piece of simulated time may begin.

    late: whether simulated time had to be let fall behind since the flag was last cleared.
    """

    def __init__(self, real_time_factor: float, now: Callable[[], float] = time.monotonic):
        self._factor = real_time_factor
        self._now = now
        self.late = False
        self.restart()

    def restart(self) -> None:
        """Begin anew, as after a pause: the time until now is not caught up with."""
        self._due = self._now()

    def delay_s(self, simulated_s: float) -> float:
        """Return the wall seconds to wait after `simulated_s` more seconds were simulated."""
        if self._factor == 0:
            return 0.0
        self._due += simulated_s / self._factor
        delay_s = self._due - self._now()
        if delay_s < -_MAX_DELAY:
            self.late = True
            self.restart()
        return max(0.0, delay_s)


class RealTimeFactor:
    """Measures the simulated seconds a second of wall time.

    last: the newest measurement, 0 before the first.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now = now
        self._since, self._simulated_s = now(), 0.0
        self.last = 0.0

    def update(self, simulated_s: float) -> Optional[float]:
        """Count simulated time; return the factor over the last second once that is over."""
        self._simulated_s += simulated_s
        passed = self._now() - self._since
        if passed < _MEASURING_S:
            return None
        self.last = self._simulated_s / passed
        self._since, self._simulated_s = self._now(), 0.0
        return self.last
