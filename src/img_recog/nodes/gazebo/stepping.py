"""Time by hand: paused at the start, and a service that lets a period pass."""
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass
from functools import partial
from typing import Optional

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from img_recog.errors import SimulationError, UserError, one_line
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.ros import parameters
from img_recog.settings import Settings, between, nearest_period, setting
from img_recog.simulation.pacing import Pace
from img_recog.simulation.simulation_settings import whole_steps
from img_recog.simulation.simulator import Simulator

_CAMERA_RATE_HZ = 30.0
_POLL_PERIOD_S = 0.1


@dataclass(frozen=True)
class SteppingSettings(Settings):
    """paused: whether time stands at 0 at the start. step_period: simulated s that ~step lets
    pass; 0 is the period of a camera of 30 Hz. It is read again at each call.
    """

    paused: bool = setting(False)
    step_period: float = setting(0.0, between(0, 3600))


class Stepping:
    """Serves ~step (std_srvs/Trigger): goes on for ~step_period while the physics is paused.

    The response comes when all messages of that time are sent.
    end: the step of the physics at which the call ends, None if there is none.
    """

    def __init__(self, calls: ServiceCalls, simulator: Simulator, pace: Pace):
        self._calls, self._simulator, self._pace = calls, simulator, pace
        self.end: Optional[int] = None
        self._done: 'Future[float]' = Future()
        rospy.Service('~step', Trigger, self._serve)

    def _serve(self, _: TriggerRequest) -> TriggerResponse:
        try:
            period_s = parameters.read(SteppingSettings).step_period
            done = self._calls.call(partial(self._begin, period_s))
        except UserError as error:
            return TriggerResponse(False, one_line(error))
        while not rospy.is_shutdown():
            try:
                return TriggerResponse(True, 'simulated time is {:.3f} s'.format(
                    done.result(_POLL_PERIOD_S)))
            except FutureTimeoutError:
                continue
        raise rospy.ServiceException('the node ends')

    def _begin(self, period_s: float) -> 'Future[float]':
        if not self._pace.is_paused:
            raise SimulationError('the physics is not paused', 'call ~pause_physics first, or '
                                  'start with paused:=true')
        if self.end is not None:
            raise SimulationError('another call of ~step has not ended', 'wait for its response')
        step_s = self._simulator.world.step_s
        self.end = self._simulator.steps + whole_steps(
            'step_period', period_s or nearest_period(_CAMERA_RATE_HZ, step_s), step_s)
        self._done = Future()
        return self._done

    def finish(self) -> None:
        """End the call, if there is one: its time has passed, or was reset."""
        if self.end is not None:
            self.end = None
            self._done.set_result(self._simulator.time_s)
