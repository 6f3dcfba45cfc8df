"""A service by which a node lets another one drive the robot for a moment."""
import time
from typing import Callable

import rospy
from std_srvs.srv import Trigger, TriggerResponse

YIELD_S = 0.5


class Yielding:
    """Serves ~yield (std_srvs/Trigger): the node publishes no commands in the next YIELD_S.

    Who wants to drive longer calls it again in time. If the caller ends, the node goes on by
    itself, so that nothing that stops the robot is off for longer.
    """

    def __init__(self, refusal: Callable[[], str] = lambda: ''):
        """Offer the service; refusal: returns why the node does not yield now, or ''."""
        self._refusal, self._until_s = refusal, 0.0
        rospy.Service('~yield', Trigger, self._yield)

    def is_active(self) -> bool:
        """Return whether the node publishes no commands now."""
        return self._until_s > 0 and time.monotonic() < self._until_s

    def _yield(self, _) -> TriggerResponse:
        reason = self._refusal()
        if reason:
            return TriggerResponse(False, reason)
        self._until_s = time.monotonic() + YIELD_S
        return TriggerResponse(True, 'no commands in the next {:g} s'.format(YIELD_S))
