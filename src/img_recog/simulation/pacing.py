"""How fast simulated time passes: pauses, pacing by real time, and the measured factor."""
import math
import time
from typing import Callable, Optional

# of wall time: with more delay the machine is too slow, and the delay is not caught up with
_MAX_DELAY_S = 0.5
_MEASURING_PERIOD_S = 1.0
_REPORT_PERIOD_S = 30.0     # of wall time, between two reports that the machine is too slow
_WORSE = 0.5


class Pace:
    """Computes how long to wait between two pieces of simulated time, and measures how it passes.

    is_paused: whether no time is to be simulated; wanted: simulated seconds per second of wall
    time, 0 for as fast as possible; measured: the same as it was last, 0 before the first second.
    """

    def __init__(self, real_time_factor: float, now: Callable[[], float] = time.monotonic):
        self.is_paused, self.measured = False, 0.0
        self._now = now
        self._since_s, self._simulated_s = now(), 0.0
        self._reported_s, self._reported = -math.inf, math.inf
        self.set_wanted(real_time_factor)

    def set_wanted(self, real_time_factor: float) -> None:
        """Go on at another factor, from now on."""
        self.wanted, self._is_late = real_time_factor, False
        self.restart()

    def pause(self) -> None:
        """Simulate nothing until `unpause`."""
        self.is_paused = True

    def unpause(self) -> None:
        """Simulate again."""
        self.is_paused = False

    def restart(self) -> None:
        """Start from now, as after a pause: the time until now is not caught up with."""
        self._due_s = self._now()

    def delay_s(self, simulated_s: float) -> float:
        """Return the wall seconds to wait after `simulated_s` more seconds were simulated."""
        if self.wanted == 0:
            return 0.0
        self._due_s += simulated_s / self.wanted
        delay_s = self._due_s - self._now()
        if delay_s < -_MAX_DELAY_S:
            self._is_late = True
            self.restart()
        return max(0.0, delay_s)

    def measure(self, simulated_s: float) -> Optional[float]:
        """Count simulated time; return the factor once a second, else None."""
        self._simulated_s += simulated_s
        passed_s = self._now() - self._since_s
        if passed_s < _MEASURING_PERIOD_S:
            return None
        self.measured = self._simulated_s / passed_s
        self._since_s, self._simulated_s = self._now(), 0.0
        return self.measured

    def is_to_report(self) -> bool:
        """Return whether to report that the machine is too slow.

        After simulated time has fallen behind: at first, when it gets worse, and rarely.
        """
        if not (self._is_late and self.measured):
            return False
        self._is_late, now_s = False, self._now()
        if now_s < self._reported_s + _REPORT_PERIOD_S and self.measured > _WORSE * self._reported:
            return False
        self._reported_s, self._reported = now_s, self.measured
        return True


def timeout_scale(real_time_factor: float) -> float:
    """Return how many times longer timeouts in simulated time are, to be as long in wall time.

    Never shorter, and for "as fast as possible" 100 times.

    >>> timeout_scale(0.5), timeout_scale(3.0), timeout_scale(0.0)
    (1.0, 3.0, 100.0)
    """
    return min(100.0, max(1.0, real_time_factor or 100.0))
