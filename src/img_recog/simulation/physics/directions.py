"""Friction along and across wheels, whose files give a direction of it.

As in ODE, the pyramid of friction turns with the wheel, in which PyBullet's stays along the axes
of the world. PyBullet scales friction along the axes of a link, and with nothing along one of them
both of its directions become the same. So there are two links with the same treads, each of which
has half of the load: one has friction around the wheel, the other one along its axle.
"""
from typing import List, NamedTuple, Optional

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.simulation.physics.client import link_indices
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tyres import ACROSS
from img_recog.simulation.physics.wheels import axis_of

_PERIOD_STEPS = 10
_PARALLEL = 0.7
# Of the angle between the floor and a direction that turns: friction is weaker by that in ODE on
# the mean, both along and across.
_MEAN_COSINE = 2 / np.pi
_FAST_RAD_S = 30.0      # from there on, the mean counts


class _Wheel(NamedTuple):
    """PyBullet's numbers of both links; axle (3,): in the frame of the center of mass; along,
    across: by what friction is scaled around the wheel and along its axle (3,), times the root of
    2 where the axle is diagonal in the world; turning: the direction (3,) in that frame, if it
    turns with the wheel."""

    link: int
    second: int
    axle: np.ndarray
    along: np.ndarray
    across: np.ndarray
    turning: Optional[np.ndarray]


class Directions:
    """The wheels of a body that have a direction of friction."""

    def __init__(self, body: FramedBody):
        self._body, self._client = body, {'physicsClientId': body.physics_client_id}
        self._wheels: List[_Wheel] = []
        indices = link_indices(body.body_id, body.physics_client_id)
        surfaces = {link.name: link.surface for link in body.model.links}
        for joint in body.model.joints:
            if joint.child + ACROSS in indices:
                link, axle = indices[joint.child], axis_of(joint)
                friction = surfaces[joint.child]
                direction = np.array(friction.direction) / np.linalg.norm(friction.direction)
                turn = rotations.matrix(pybullet.getDynamicsInfo(
                    body.body_id, link, **self._client)[4]).T
                is_axle = np.abs(turn @ axle) > _PARALLEL
                along, across = np.full(3, friction.across), friction.mu
                turning = None
                if abs(axle @ direction) < _PARALLEL:
                    turning = turn @ direction
                    along = np.where(np.abs(turn @ direction) > _PARALLEL, friction.mu,
                                     friction.mu * (2 * _MEAN_COSINE - 1))
                    across = friction.across * _MEAN_COSINE
                # twice of it on half of the load
                half = 2 / (friction.largest or 1.0)
                self._wheels.append(_Wheel(
                    link, indices[joint.child + ACROSS], turn @ axle,
                    np.where(is_axle, 0.0, along * half), np.where(is_axle, across * half, 0.0),
                    turning))
        self.reset()

    def __bool__(self) -> bool:
        return bool(self._wheels)

    def reset(self) -> None:
        """Forget when the directions were set: to be called when all was moved to its start."""
        self._steps = 0

    def update(self) -> None:
        """Set the friction for where the axles point; to be called before each step."""
        if self._steps % _PERIOD_STEPS == 0:
            for wheel in self._wheels:
                turned = pybullet.getLinkState(self._body.body_id, wheel.link,
                                               computeForwardKinematics=1, **self._client)[1]
                turn = rotations.matrix(turned)
                x, y, _ = turn @ wheel.axle
                # the limits of both of PyBullet's directions add up
                sum_of_both = (abs(x) + abs(y)) / (np.hypot(x, y) or 1.0) or 1.0
                across = wheel.across
                if wheel.turning is not None and abs(pybullet.getJointState(
                        self._body.body_id, wheel.link, **self._client)[1]) < _FAST_RAD_S:
                    across = across / _MEAN_COSINE * np.hypot(*(turn @ wheel.turning)[:2])
                for link, scales in ((wheel.link, wheel.along), (wheel.second, across)):
                    pybullet.changeDynamics(
                        self._body.body_id, link,
                        anisotropicFriction=(scales / sum_of_both).tolist(), **self._client)
        self._steps += 1
