"""When frames were captured, as a clock tells that may stand still or jump."""
from typing import Optional


class Stamps:
    """Makes strictly increasing stamps, also while the clock stands still.

    When the clock jumps back, as a simulation's does when it is reset, so do the stamps, once.
    """

    def __init__(self):
        self._last_ns: Optional[int] = None
        self._last_now_ns: Optional[int] = None

    def stamp_ns(self, now_ns: int, age_s: float = 0.0) -> int:
        """Return the stamp of a frame captured `age_s` ago by a clock that shows `now_ns`."""
        stamp_ns = max(0, now_ns - int(age_s * 1e9))
        jumped = self._last_now_ns is not None and now_ns < self._last_now_ns
        if self._last_ns is not None and not jumped:
            stamp_ns = max(stamp_ns, self._last_ns + 1)
        self._last_ns, self._last_now_ns = stamp_ns, now_ns
        return stamp_ns
