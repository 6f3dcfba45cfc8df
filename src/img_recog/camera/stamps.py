"""Stamps of frames by a clock that may stop or jump, as simulated time does."""
from typing import Optional


class Stamps:
    """Makes strictly increasing stamps, also while the clock is stopped.

    When the clock jumps back, as that of a simulation does on a reset, the stamps follow.
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
