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


class Throttle:
    """Leaves out frames of a camera that gives more than `rate_hz`, evenly.

    A camera within a twentieth of the rate is let through whole: two clocks never agree, and a
    frame would be missing now and then.
    """

    _TOLERANCE = 0.05
    _SMOOTHING = 0.1        # share of the newest interval in their mean

    def __init__(self, rate_hz: float):
        self._period_s = 1.0 / rate_hz
        self._last_s = self._interval_s = self._due_s = None

    def accepts(self, captured_s: float) -> bool:
        """Return whether to keep the frame captured at this time, of any steady clock."""
        if self._last_s is None:
            self._last_s, self._due_s = captured_s, captured_s + self._period_s
            return True
        interval_s, self._last_s = max(0.0, captured_s - self._last_s), captured_s
        if self._interval_s is None:
            self._interval_s = interval_s
        # a pause says nothing about the rate
        interval_s = min(interval_s, 4.0 * self._period_s)
        self._interval_s += self._SMOOTHING * (interval_s - self._interval_s)
        if self._interval_s > (1.0 - self._TOLERANCE) * self._period_s:
            self._due_s = captured_s + self._period_s
            return True
        # the frame next to the due time, before it or after
        if captured_s < self._due_s - 0.5 * self._interval_s:
            return False
        self._due_s += self._period_s
        if self._due_s < captured_s:
            self._due_s = captured_s + self._period_s
        return True
