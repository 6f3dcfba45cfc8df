"""What changes the physics while it runs: services, parameters, and the queue of all calls."""
from concurrent.futures import TimeoutError as CallTimeoutError
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Mapping

import rospy
from std_srvs.srv import Empty, EmptyResponse

from img_recog.errors import SimulationError
from img_recog.ros.diagnostics import EventCounter
from img_recog.ros.queues import CallQueue
from img_recog.settings import Settings, one_of, setting
from img_recog.simulation.simulation_settings import REAL_TIME_FACTORS, VIEWS

_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class RuntimeSettings(Settings):
    """Parameters that dynamic_reconfigure changes; see PhysicsSettings and ViewSettings."""

    real_time_factor: float = setting(
        1.0, REAL_TIME_FACTORS, 'simulated seconds per second of wall time; 0: no limit')
    view: str = setting('above', one_of(*VIEWS), 'viewpoint of ~view/image_raw')


class ServiceCalls(CallQueue):
    """Lets the loop that steps the simulation do what service handlers need done.

    late: counts the calls that the loop did not do in time.
    """

    def __init__(self):
        super().__init__()
        self.late = EventCounter()

    def call(self, action: Callable[[], Any], timeout_s: float = _TIMEOUT_S) -> Any:
        """Have the loop call `action`; return what it returns, raise what it raises.

        Raises SimulationError when the loop does not do so in time.
        """
        try:
            return super().call(action, timeout_s)
        except CallTimeoutError:
            self.late.add()
            raise SimulationError('the simulation did not answer within {:g} s'.format(timeout_s),
                                  'wait and look: what it has begun, it completes')


def serve_physics(calls: ServiceCalls, actions: Mapping[str, Callable[[], None]]) -> None:
    """Serve private services of type std_srvs/Empty, like those of gazebo_ros.

    actions: what the loop does for each service, by the service's name without ~.
    """
    def handle(name: str, _: object) -> EmptyResponse:
        try:
            calls.call(actions[name])
        except SimulationError as error:
            raise rospy.ServiceException('{}: {}'.format(name, error))
        return EmptyResponse()
    for name in actions:
        rospy.Service('~' + name, Empty, partial(handle, name))
