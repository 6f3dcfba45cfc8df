"""Evenly spaced deadlines for sources that have no clock of their own."""
import time
from typing import Callable


class Pacer:
    """Tells how long to wait before each frame of a stream of `rate_hz`.

    Deadlines are multiples of the period from the first frame on, so that errors do not add up.
    A deadline missed by more than a period is dropped, not caught up with in a burst.
    """

    def __init__(self, rate_hz: float, now: Callable[[], float] = time.monotonic):
        self._period_s = 1.0 / rate_hz
        self._now = now
        self._deadline = None

    def delay_s(self) -> float:
        """Return the seconds until the next frame is due, 0 if it is due, and move on to it."""
        now = self._now()
        if self._deadline is None:
            self._deadline = now
        late_s = now - self._deadline
        if late_s > self._period_s:
            self._deadline += (late_s // self._period_s) * self._period_s
        delay_s = max(0.0, self._deadline - now)
        self._deadline += self._period_s
        return delay_s
