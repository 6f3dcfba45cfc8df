"""Holds simulated time to real time."""
import time
from typing import Callable

# s of wall time: a machine that is later than this is too slow, and the difference is let go
_MAX_DELAY = 0.5


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
