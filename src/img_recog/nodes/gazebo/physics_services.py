"""The services that pause and reset the simulation, and the queue of all service calls."""
from concurrent.futures import TimeoutError as CallTimeoutError
from typing import Any, Callable, Mapping

import rospy
from std_srvs.srv import Empty, EmptyResponse

from img_recog.ros.diagnostics import Counter
from img_recog.ros.queues import CallQueue
from img_recog.simulation.settings import SimulationError

_TIMEOUT_S = 5.0


class ServiceCalls:
    """Lets the loop that steps the simulation do what service handlers need done.

    late: counts the calls that the loop did not do in time.
    """

    def __init__(self):
        self._queue = CallQueue()
        self.late = Counter()

    @property
    def waiting(self) -> int:
        """The number of calls that the loop has not begun."""
        return len(self._queue)

    def call(self, action: Callable[[], Any]) -> Any:
        """Have the loop call `action`; return what it returns, raise what it raises.

        Raises SimulationError when the loop does not do so in time.
        """
        try:
            return self._queue.call(action, _TIMEOUT_S)
        except CallTimeoutError:
            self.late.add()
            raise SimulationError('the simulation did not answer within {:g} s'.format(_TIMEOUT_S),
                                  'wait and look: what it has begun, it completes')

    def process(self, timeout_s: float) -> None:
        """Call in the loop: do the waiting calls, or wait up to `timeout_s` for the first."""
        self._queue.process(timeout_s)


class PhysicsServices:
    """Serves private services of type std_srvs/Empty, like those of gazebo_ros."""

    def __init__(self, calls: ServiceCalls, actions: Mapping[str, Callable[[], None]]):
        """Advertise.

        actions: what the loop does for each service, by the service's name without ~.
        """
        self._calls = calls
        for name, action in actions.items():
            rospy.Service('~' + name, Empty, self._handler(name, action))

    def _handler(self, name: str, action: Callable[[], None]) -> Callable[[Any], EmptyResponse]:
        def handle(_: Any) -> EmptyResponse:
            try:
                self._calls.call(action)
            except SimulationError as error:
                raise rospy.ServiceException('{}: {}'.format(name, error))
            return EmptyResponse()
        return handle
