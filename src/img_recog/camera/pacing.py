"""When frames are due, are kept and were captured: pacing, a limit of the rate, and stamps."""
import time
from typing import Callable, Optional


class Pacer:
    """Computes how long to wait before each frame of a stream of `rate_hz`.

    Deadlines are multiples of the period, counted from the first frame, so errors do not add up.
    Deadlines that are missed by more than a period are dropped: there is no burst of frames.

    >>> times_s = iter([0.0, 0.125, 0.75, 2.0])
    >>> pacer = Pacer(2.0, lambda: next(times_s))
    >>> [pacer.delay_s() for _ in range(4)]
    [0.0, 0.375, 0.25, 0.0]
    """

    def __init__(self, rate_hz: float, now: Callable[[], float] = time.monotonic):
        self._period_s = 1.0 / rate_hz
        self._now = now
        self._deadline_s: Optional[float] = None

    def delay_s(self) -> float:
        """Return the seconds until the next frame is due, 0 if it is late; advance to it."""
        now_s = self._now()
        deadline_s = now_s if self._deadline_s is None else self._deadline_s
        late_s = now_s - deadline_s
        if late_s > self._period_s:
            deadline_s += (late_s // self._period_s) * self._period_s
        delay_s = max(0.0, deadline_s - now_s)
        self._deadline_s = deadline_s + self._period_s
        return delay_s


class Throttle:
    """Drops frames of a camera that gives more than `rate_hz`, evenly.

    A camera that exceeds the rate by less than 5 % keeps all its frames: two clocks never agree,
    and otherwise a frame would be dropped now and then.

    >>> throttle = Throttle(10.0)
    >>> [throttle.accepts(number / 20) for number in range(6)]
    [True, False, True, False, True, False]
    """

    _TOLERANCE = 0.05
    _SMOOTHING = 0.1        # weight of the newest interval in their moving average

    def __init__(self, rate_hz: float):
        self._period_s = 1.0 / rate_hz
        self._last_s: Optional[float] = None
        self._interval_s: Optional[float] = None
        self._due_s = 0.0

    def accepts(self, captured_s: float) -> bool:
        """Return whether to keep the frame captured at this time, by any steady clock."""
        if self._last_s is None:
            self._last_s, self._due_s = captured_s, captured_s + self._period_s
            return True
        interval_s, self._last_s = max(0.0, captured_s - self._last_s), captured_s
        if self._interval_s is None:
            self._interval_s = interval_s
        # a pause is not the period of the camera
        interval_s = min(interval_s, 4.0 * self._period_s)
        self._interval_s += self._SMOOTHING * (interval_s - self._interval_s)
        if self._interval_s > (1.0 - self._TOLERANCE) * self._period_s:
            self._due_s = captured_s + self._period_s
            return True
        # keep the frame that is closest to the due time, before or after it
        if captured_s < self._due_s - 0.5 * self._interval_s:
            return False
        self._due_s += self._period_s
        if self._due_s < captured_s:
            self._due_s = captured_s + self._period_s
        return True


class Stamps:
    """Makes strictly increasing stamps, also while the clock is stopped.

    When the clock jumps back, as that of a simulation does on a reset, the stamps follow.

    >>> stamps = Stamps()
    >>> [stamps.stamp_ns(now_ns) for now_ns in (1000, 1000, 1000, 400)]
    [1000, 1001, 1002, 400]
    """

    def __init__(self) -> None:
        self._last_ns: Optional[int] = None
        self._last_now_ns: Optional[int] = None

    def stamp_ns(self, now_ns: int, age_s: float = 0.0) -> int:
        """Return the stamp of a frame that was captured `age_s` before the time `now_ns`."""
        stamp_ns = max(0, now_ns - int(age_s * 1e9))
        jumped = self._last_now_ns is not None and now_ns < self._last_now_ns
        if self._last_ns is not None and not jumped:
            stamp_ns = max(stamp_ns, self._last_ns + 1)
        self._last_ns, self._last_now_ns = stamp_ns, now_ns
        return stamp_ns
