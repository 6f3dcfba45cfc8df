"""Lets bodies at rest fall asleep like ODE does, so that they cost little.

A body that was slow for 1 s falls asleep if it rests on something, and all that is near sleeps, is
fixed or falls asleep with it. PyBullet leaves out a group of bodies that all sleep, and wakes the
group when a body that is awake comes near. It does not notice that a body was moved, removed
or pushed from outside: then `wake` or `wake_near` must be called. PyBullet leaves out a body in
the step after that, too, and sets its velocity to 0 in that step.
"""
import math
from typing import Any, Dict, Iterable, List, Optional, Set

import pybullet

from img_recog.simulation.physics import crowding
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.framed_body import FramedBody

# the rule of Gazebo 11 for ODE, see ODEPhysics::Load and dInternalHandleAutoDisabling
IDLE_S, _IDLE_SPEED = 1.0, 0.1          # m/s and rad/s
_NEAR_M = 0.05          # PyBullet enlarges the boxes around bodies by this (gDbvtMargin)
_PERIOD_S = 0.05        # between two checks
_PERIODS_ASLEEP = 10    # between two checks whether PyBullet has woken a body
# how often a body was found slow: from _IDLE on it can stop, which takes PyBullet a step
_IDLE = 1 + round(IDLE_S / _PERIOD_S)
_STOPS, _ASLEEP = _IDLE + 1, _IDLE + 2
# the sum of squared velocities above which PyBullet wakes a body: while it stops, and asleep
_THRESHOLDS = {_STOPS: 2 * _IDLE_SPEED ** 2, _ASLEEP: 1e-12}
_SLEEP = pybullet.ACTIVATION_STATE_ENABLE_SLEEPING | pybullet.ACTIVATION_STATE_SLEEP
_WAKE = pybullet.ACTIVATION_STATE_DISABLE_SLEEPING | pybullet.ACTIVATION_STATE_WAKE_UP


class Sleeping:
    """The bodies of a client that can fall asleep; true if there are any."""

    def __init__(self, physics_client_id: int, step_s: float):
        self._client = {'physicsClientId': physics_client_id}
        self._period, self._steps = max(1, round(_PERIOD_S / step_s)), 0
        self._counts: Dict[int, int] = {}       # in how many checks in a row each body was slow
        self._bodies: Dict[int, FramedBody] = {}
        self._fixed: Set[int] = set()
        self._velocities: Dict[int, Any] = {}   # of moved bodies that slept, after the next step
        self._stopped = self._velocities        # the same, in that step

    def __bool__(self) -> bool:
        return bool(self._counts)

    @property
    def asleep(self) -> Set[int]:
        """PyBullet's numbers of the bodies that slept at the last check."""
        return {body for body, count in self._counts.items() if count == _ASLEEP}

    def add(self, body: FramedBody, has_forces: bool = False) -> None:
        """Add a body, which is awake.

        has_forces: whether forces act on it in each step, which keep it awake.
        """
        if body.fixed and not body.joints:
            self._fixed.add(body.body_id)
            if body.is_plane:       # no contacts are computed between two bodies that sleep
                self._set(body.body_id, _SLEEP, _ASLEEP)
        elif body.model.can_sleep and not (body.fixed or body.joints or has_forces):
            self._bodies[body.body_id], self._counts[body.body_id] = body, 0

    def forget(self, body: Body) -> None:
        """Wake what a body touches; call it before the body is removed."""
        self.wake_near(body)
        for known in (self._counts, self._velocities, self._stopped):
            known.pop(body.body_id, None)
        self._fixed.discard(body.body_id)

    def wake(self, bodies: Optional[Iterable[int]] = None) -> List[int]:
        """Wake bodies, and let their time at rest begin anew; return those that slept.

        bodies: PyBullet's numbers, by default of all.
        """
        found = self._counts.keys() & (self._counts if bodies is None else set(bodies))
        slept = [body for body in found if self._counts[body] > _IDLE]
        for body in slept:
            self._set(body, _WAKE, _ASLEEP)
        self._counts.update(dict.fromkeys(found, 0))
        return slept

    def wake_near(self, body: Body) -> bool:
        """Wake what a body touched in the last step, and what it is close to now.

        Returns whether the body itself slept. If so, it keeps the velocity that it has now.
        """
        if max(self._counts.values(), default=0) > _IDLE:
            near = crowding.near_bodies(body, _NEAR_M)
            self.wake({*near, *(point.other for point in body.contacts())} - {body.body_id})
        slept = bool(self.wake([body.body_id])) or body.body_id in self._velocities
        self._stopped.pop(body.body_id, None)
        if slept:
            self._velocities[body.body_id] = pybullet.getBaseVelocity(
                body.body_id, **self._client)
        return slept

    def reset(self) -> None:
        """Wake all bodies, to the last bit; call it before they are moved to their start."""
        self._steps, self._velocities, self._stopped = 0, {}, {}
        if self.wake():
            pybullet.stepSimulation(**self._client)

    def before_steps(self, most: int) -> int:
        """Let bodies fall asleep, if it is time for that.

        Returns how many steps must be done before the next call, at most `most`.
        """
        for body, velocity in self._stopped.items():
            pybullet.resetBaseVelocity(body, *velocity, **self._client)
        self._stopped, self._velocities = self._velocities, {}
        periods, steps = divmod(self._steps, self._period)
        if steps == 0:
            self._check(periods % _PERIODS_ASLEEP == 0)
        steps = min(most, 1 if self._stopped else self._period - steps)
        self._steps += steps
        return steps

    def _check(self, also_asleep: bool) -> None:
        for body, count in self._counts.items():
            if count < _ASLEEP or also_asleep:
                velocities = pybullet.getBaseVelocity(body, **self._client)
                if max(math.hypot(*each) for each in velocities) > _IDLE_SPEED * (count < _ASLEEP):
                    self.wake([body])
                elif count < _IDLE:
                    self._counts[body] += 1
        idle = {body for body, count in self._counts.items() if _IDLE <= count < _ASLEEP}
        settled = self._settled(idle) if idle else idle
        self.wake(body for body in idle - settled if self._counts[body] == _STOPS)
        for body in settled:
            self._counts[body] += 1
            self._set(body, _SLEEP, self._counts[body])

    def _settled(self, bodies: Set[int]) -> Set[int]:
        """Return those of the bodies that rest on something and are near to nothing that moves."""
        others = {body: set(crowding.near_bodies(self._bodies[body], _NEAR_M)) for body in bodies
                  if any(point.force > 0 for point in self._bodies[body].contacts())}
        still, settled = self._fixed | self.asleep, set(others)
        while True:
            restless = {body for body in settled if not others[body] <= settled | still}
            if not restless:
                return settled
            settled -= restless

    def _set(self, body: int, state: int, count: int) -> None:
        pybullet.changeDynamics(body, -1, activationState=state,
                                sleepThreshold=_THRESHOLDS[count], **self._client)
