"""What changes the physics and its time while it runs: services, and the queue of all calls."""
from concurrent.futures import Future
from concurrent.futures import TimeoutError as CallTimeoutError
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, Mapping

import rospy
from diagnostic_updater import DiagnosticStatusWrapper
from std_srvs.srv import Empty, EmptyResponse, Trigger, TriggerRequest, TriggerResponse

from img_recog.errors import SimulationError, UserError, one_line
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate
from img_recog.ros import parameters
from img_recog.ros.diagnostics import EventCounter
from img_recog.ros.queues import CallQueue
from img_recog.settings import Settings, between, nearest_period, one_of, setting
from img_recog.simulation.simulation_settings import REAL_TIME_FACTORS, VIEWS, whole_steps
from img_recog.simulation.simulator import Simulator

_TIMEOUT_S = 5.0
_CAMERA_RATE_HZ = 30.0


@dataclass(frozen=True)
class RuntimeSettings(Settings):
    """Parameters that dynamic_reconfigure changes; see PhysicsSettings and ViewSettings."""

    real_time_factor: float = setting(
        1.0, REAL_TIME_FACTORS, 'simulated seconds per second of wall time; 0: no limit')
    view: str = setting('above', one_of(*VIEWS), 'viewpoint of ~view/image_raw')


@dataclass(frozen=True)
class SteppingSettings(Settings):
    """paused: whether time is paused at 0 at the start. step_period: simulated s that ~step lets
    pass; 0 is the period of a camera of 30 Hz. It is read again at each call.
    """

    paused: bool = setting(False)
    step_period: float = setting(0.0, between(0, 3600))


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

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Add to a status how many calls wait, and were late; may be called in any thread."""
        status.add('waiting service calls', str(len(self)))
        status.add('service calls that timed out', str(self.late.total))


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


def serve_step(calls: ServiceCalls, simulator: Simulator, gate: TimeGate) -> None:
    """Serve ~step (std_srvs/Trigger): time passes for ~step_period while it is paused.

    The response comes when all messages of that time are sent.
    """
    def begin(period_s: float) -> 'Future[float]':
        step_s, done = simulator.world.step_s, Future()     # type: float, Future[float]
        end = simulator.steps + whole_steps(
            'step_period', period_s or nearest_period(_CAMERA_RATE_HZ, step_s), step_s)
        gate.step(end, lambda: done.set_result(simulator.time_s))
        return done

    def handle(_: TriggerRequest) -> TriggerResponse:
        try:
            period_s = parameters.read(SteppingSettings).step_period
            done = calls.call(partial(begin, period_s))
        except UserError as error:
            return TriggerResponse(False, one_line(error))
        time_s = done.result()
        if gate.mode is Mode.SHUT_DOWN:
            raise rospy.ServiceException('the node ends')
        return TriggerResponse(True, 'simulated time is {:.3f} s'.format(time_s))
    rospy.Service('~step', Trigger, handle)
