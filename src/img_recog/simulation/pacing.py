"""How fast simulated time passes: pacing by real time, and the measured factor."""
import math
import time
from typing import Optional

_MAX_DELAY_S = 0.5          # of wall time: a longer delay is not caught up with
_MEASURING_PERIOD_S = 1.0
# The machine is too slow below this share of the wanted factor, in two measurements in a row: one
# may be a start, or another program. Five others end it.
_MIN_SHARE, _SLOW_COUNT, _FAST_COUNT = 0.9, 2, 5
_REPORT_PERIOD_S = 30.0     # of wall time, between two reports that the machine is too slow
_WORSE = 0.5


class Pace:
    """Computes how long to wait between two pieces of simulated time, and measures how it passes.

    All methods are for the thread that simulates, which alone sets the attributes.

    Attributes:
        wanted: Simulated seconds per second of wall time, 0 for as fast as possible.
        measured: The same as it was last, 0 before the first second.
    """

    def __init__(self, real_time_factor: float):
        self.measured = 0.0
        self._since_s, self._simulated_s = time.monotonic(), 0.0
        self._row = 0       # measurements in a row that were too slow; negative: that were not
        self._reported_s, self._reported = -math.inf, math.inf
        self.set_wanted(real_time_factor)

    def set_wanted(self, real_time_factor: float) -> None:
        """Go on at another factor, from now on."""
        self.wanted = real_time_factor
        self.restart()

    def restart(self) -> None:
        """Start from now, as after a pause: the time until now is not caught up with."""
        self._due_s = time.monotonic()
        self.disturb()

    def disturb(self) -> None:
        """Do not judge the machine by the current measurement, as while robots are added."""
        self._is_disturbed = True

    def delay_s(self, simulated_s: float) -> float:
        """Return the wall seconds to wait after `simulated_s` more seconds were simulated."""
        if self.wanted == 0:
            return 0.0
        self._due_s += simulated_s / self.wanted
        delay_s = self._due_s - time.monotonic()
        if delay_s < -_MAX_DELAY_S:
            self._due_s = time.monotonic()
        return max(0.0, delay_s)

    def measure(self, simulated_s: float) -> Optional[float]:
        """Count simulated time; return the factor once a second, else None."""
        self._simulated_s += simulated_s
        passed_s = time.monotonic() - self._since_s
        if passed_s < _MEASURING_PERIOD_S:
            return None
        self.measured = self._simulated_s / passed_s
        self._since_s, self._simulated_s = time.monotonic(), 0.0
        is_slow = self.measured < _MIN_SHARE * self.wanted and not self._is_disturbed
        self._row = max(0, self._row) + 1 if is_slow else (
            0 if self._is_disturbed else min(0, self._row) - 1)
        self._is_disturbed = False
        return self.measured

    def take_report(self) -> Optional[bool]:
        """Return what to report: True if the machine is too slow, False if no longer, else None.

        It is too slow at first, when it gets worse, and rarely.
        """
        now_s = time.monotonic()
        if self._row >= _SLOW_COUNT and (now_s >= self._reported_s + _REPORT_PERIOD_S
                                         or self.measured <= _WORSE * self._reported):
            self._reported_s, self._reported = now_s, self.measured
            return True
        if self._row <= -_FAST_COUNT and self._reported < math.inf:
            self._reported_s, self._reported = -math.inf, math.inf
            return False
        return None


def timeout_scale(real_time_factor: float) -> float:
    """Return how many times longer timeouts in simulated time are, to be as long in wall time.

    Never shorter, and for "as fast as possible" 100 times.

    >>> timeout_scale(0.5), timeout_scale(3.0), timeout_scale(0.0)
    (1.0, 3.0, 100.0)
    """
    return min(100.0, max(1.0, real_time_factor or 100.0))
