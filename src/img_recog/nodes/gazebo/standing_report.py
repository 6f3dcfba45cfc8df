"""Says for whom simulated time stands."""
import time

import rospy

_PERIOD_S = 5.0     # of wall time


class StandingReport:
    """Logs it, first after 5 s of wall time, and not more often than every 5 s."""

    def __init__(self, prefix: str = ''):
        """prefix: of each line."""
        self._prefix, self._reported_s = prefix, time.monotonic()

    def __call__(self, time_s: float, missing: str, since_s: float = 0.0) -> None:
        """Log that time stands at `time_s` and waits for what is missing, if it is time to.

        since_s: when that began, as of time.monotonic.
        """
        now_s = time.monotonic()
        if now_s >= max(self._reported_s, since_s) + _PERIOD_S:
            self._reported_s = now_s
            rospy.logwarn('%ssimulated time stands at %.3f s and waits for: %s', self._prefix,
                          time_s, missing)
