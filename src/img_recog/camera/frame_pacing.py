"""When frames are due, are kept and were captured: pacing, a limit of the rate, and stamps."""
import time
from typing import Callable, Optional


class Pacer:
    """Computes how long to wait before each frame of a stream.

    Deadlines are counted from the first frame, so errors do not add up: the times of the frames
    if they have some, else multiples of the period of `rate_hz`. A frame that is late by more than
    a period delays the later ones by whole periods: there is no burst of frames.

    late: number of these periods so far.

    >>> times_s = iter([0.0, 0.125, 0.75, 2.125])
    >>> pacer = Pacer(2.0, lambda: next(times_s))
    >>> [pacer.delay_s() for _ in range(4)]
    [0.0, 0.375, 0.25, 0.0]
    >>> pacer.late
    1
    """

    def __init__(self, rate_hz: float, now: Callable[[], float] = time.monotonic):
        self._period_s = 1.0 / rate_hz
        self._now = now
        self._start_s: Optional[float] = None       # when the time 0 is due
        self._count = self.late = 0
        self._time_s = self._offset_s = 0.0     # of the last frame; of the times of a film

    def delay_s(self, time_s: Optional[float] = None) -> float:
        """Return the seconds until the next frame is due, 0 if it is late; advance to it.

        time_s: the time of this frame; None: a period after the one before.
        """
        now_s = self._now()
        time_s = self._count * self._period_s if time_s is None else self._offset_s + time_s
        self._time_s = time_s
        self._count += 1
        if self._start_s is None:
            self._start_s = now_s - time_s
        late_s = now_s - self._start_s - time_s
        if late_s > self._period_s:
            periods = int(late_s // self._period_s)
            self._start_s += periods * self._period_s
            self.late += periods
        return max(0.0, self._start_s + time_s - now_s)

    def restart(self, step_s: float) -> None:
        """Have the times of frames begin with 0 again, which is due a step after the last one."""
        self._offset_s = self._time_s + step_s


class FrameTimes:
    """Times of the frames of a film, from those that its decoder gives, if it gives any.

    A time within 1 ms of the multiple of the period is this multiple: containers round to 1 ms. A
    decoder time that does not increase, or jumps by more than the longest step, by default an
    hour, counts as none: the frame then follows the one before as that has followed its own.

    step_s: between the last two frames; before, the stated period, 0 if there is none.
    longest_step_s: the longest so far.

    >>> times = FrameTimes(8.0)
    >>> [times.next_s(decoder_s) for decoder_s in (0.0, 0.1254, 0.375, None, 0.02)]
    [0.0, 0.125, 0.375, 0.625, 0.875]
    """

    _ROUNDING_S = 1e-3

    def __init__(self, rate_hz: float, max_step_s: float = 3600.0):
        """Begin before the first frame of a film that states the rate `rate_hz`, 0 if none."""
        self._rate_hz, self._max_step_s = rate_hz, max_step_s
        self._count, self._time_s = 0, 0.0
        self._decoder_s: Optional[float] = None
        self._offset_s = 0.0        # of the decoder's times
        self.step_s = 1.0 / rate_hz if rate_hz > 0 else 0.0
        self.longest_step_s = self.step_s

    def is_even(self) -> bool:
        """Return whether the last step is the period of the stated rate."""
        return self._rate_hz > 0 and abs(self.step_s - 1.0 / self._rate_hz) <= self._ROUNDING_S

    def next_s(self, decoder_s: Optional[float]) -> float:
        """Return the time of the next frame, which increases, by that of the decoder, if any."""
        if decoder_s is not None and self._decoder_s is not None and (
                0.0 < decoder_s - self._decoder_s <= self._max_step_s):
            time_s = decoder_s - self._offset_s
        else:
            time_s = self._time_s + self.step_s if self._count else 0.0
            self._offset_s = (decoder_s or 0.0) - time_s
        if self._rate_hz > 0 and abs(
                time_s - self._count / self._rate_hz) <= self._ROUNDING_S:
            time_s = self._count / self._rate_hz
        if self._count:
            self.step_s = time_s - self._time_s
            self.longest_step_s = max(self.longest_step_s, self.step_s)
        self._decoder_s, self._time_s = decoder_s, time_s
        self._count += 1
        return time_s


class RateLimit:
    """Drops frames of a camera that gives more than `rate_hz`, evenly.

    A camera that exceeds the rate by less than 5 % keeps all its frames: two clocks never agree,
    and otherwise a frame would be dropped now and then.

    >>> limit = RateLimit(10.0)
    >>> [limit.accepts(number / 20) for number in range(6)]
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
