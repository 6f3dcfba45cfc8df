"""A limit for how much may come in: at once, and in the long run."""


class TokenBucket:
    """Lets pass at most a burst at once, and a rate in the long run."""

    def __init__(self, burst: float, rate_hz: float):
        self._burst = self._left = burst
        self._rate_hz = rate_hz

    def take(self, count: float, waited_s: float) -> bool:
        """Count what has come in after a time without it; return whether it is allowed."""
        self._left = min(self._burst, self._left + waited_s * self._rate_hz) - count
        return self._left >= 0
