"""Friction along and across wheels, whose files give a direction of it.

As in ODE, the pyramid of friction turns with the wheel, in which PyBullet's stays along the axes
of the world. PyBullet scales friction along the axes of a link, and with nothing along one of them
both of its directions become the same. So there are two links with the same treads, each of which
has half of the load: one has friction around the wheel, the other one along its axle.

A wheel that does not come near to slipping needs neither: a contact costs as much as half of all
else of a small robot. Then the second link meets nothing, and the first one has the load, with the
lowest coefficient of the wheel in all directions.
"""
import math
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.simulation.physics import meeting, stiffness
from img_recog.simulation.physics.body import Vector
from img_recog.simulation.physics.client import link_indices
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tyres import ACROSS

_PERIOD_STEPS, _GRIPPING_STEPS = 10, 40
_PARALLEL = 0.7
# Of the angle between the floor and a direction that turns: friction is weaker by that in ODE on
# the mean, both along and across.
_MEAN_COSINE = 2 / np.pi
_FAST_RAD_S = 30.0      # from there on, the mean counts
_SLIPS_FROM = 0.8       # of the lowest friction that it can have
_GRIPS_AFTER = 5       # periods without that
_LITTLE = 0.01

Coefficient = Callable[[int, int], float]       # of a link of a body, by PyBullet's numbers


class _Wheel(NamedTuple):
    """PyBullet's numbers of both links; axle (3,): in the frame of the center of mass; along,
    across: by what friction is scaled around the wheel and along its axle (3,), times the root of
    2 where the axle is diagonal in the world; turning: the direction (3,) in that frame, if it
    turns with the wheel; lowest: by what friction is scaled if it grips, 0 if it never does;
    bitmask: of its solids."""

    link: int
    second: int
    axle: Vector
    along: Vector
    across: Vector
    turning: Optional[Vector]
    lowest: float
    bitmask: int


class Directions:
    """The wheels of a body that have a direction of friction."""

    def __init__(self, body: FramedBody, coefficient: Coefficient):
        self._coefficient = coefficient
        self._body, self._client = body, {'physicsClientId': body.physics_client_id}
        self._wheels: List[_Wheel] = []
        indices = link_indices(body.body_id, body.physics_client_id)
        surfaces = {link.name: link.surface for link in body.model.links}
        bitmasks = {link.name: link.solids[0].bitmask for link in body.model.links if link.solids}
        self._springs = stiffness.springs(body)
        for joint in body.model.joints:
            if joint.child + ACROSS in indices:
                link, axle = indices[joint.child], np.asarray(joint.axis)
                surface = surfaces[joint.child]
                direction = np.array(surface.direction) / np.linalg.norm(surface.direction)
                turn = rotations.matrix(pybullet.getDynamicsInfo(
                    body.body_id, link, **self._client)[4]).T
                is_axle = np.abs(turn @ axle) > _PARALLEL
                along, across = np.full(3, surface.across), surface.mu
                turning = None
                if abs(axle @ direction) < _PARALLEL:
                    turning = _vector(turn @ direction)
                    along = np.where(np.abs(turn @ direction) > _PARALLEL, surface.mu,
                                     surface.mu * (2 * _MEAN_COSINE - 1))
                    across = surface.across * _MEAN_COSINE
                # twice of it on half of the load
                half = 2 / (surface.largest or 1.0)
                self._wheels.append(_Wheel(
                    link, indices[joint.child + ACROSS], _vector(turn @ axle),
                    _vector(np.where(is_axle, 0.0, along * half)),
                    _vector(np.where(is_axle, across * half, 0.0)), turning,
                    min(*along[~is_axle], across) * half / 2,
                    bitmasks[joint.child]))
        self._of_link = {link: wheel for wheel in self._wheels
                         for link in (wheel.link, wheel.second)}
        self.reset()

    def __bool__(self) -> bool:
        return bool(self._wheels)

    def reset(self) -> None:
        """Forget what slipped: to be called when all was moved to its start."""
        self._wait = 0
        self._periods: Dict[int, int] = {}      # until the wheel of a link grips, 0 if it does

    def before_steps(self, most: int) -> int:
        """Set the friction for where the axles point, if it is time for that.

        Returns for how many steps that is right, at most `most`: do not do more before the next
        call, and tell `stepped` how many were done.
        """
        if self._wait == 0:
            near = set(self._near_to_slipping())
            for wheel in self._wheels:
                before = self._periods.get(wheel.link)
                now = (_GRIPS_AFTER if wheel.link in near or not wheel.lowest
                       else max((before or 0) - 1, 0))
                self._periods[wheel.link] = now
                if before is None or bool(before) != bool(now):
                    self._divide(wheel, bool(now))
                if now:
                    self._turn(wheel)
            self._wait = _PERIOD_STEPS if any(self._periods.values()) else _GRIPPING_STEPS
        return min(most, self._wait)

    def stepped(self, count: int) -> None:
        """Count steps that were done."""
        self._wait -= count

    def _near_to_slipping(self) -> Iterator[int]:
        """Yield the first link of each wheel with more force along the floor than is sure."""
        for contact in pybullet.getContactPoints(bodyA=self._body.body_id, **self._client):
            wheel = self._of_link.get(contact[3])
            if wheel is not None:
                normal, one, (x1, y1, z1), other, (x2, y2, z2) = contact[9:14]
                # PyBullet's directions are as long as friction is scaled by
                squared = ((one * x1 + other * x2) ** 2 + (one * y1 + other * y2) ** 2
                           + (one * z1 + other * z2) ** 2)
                load = 2 * normal if self._periods.get(wheel.link) else normal
                limit = _SLIPS_FROM * load * wheel.lowest
                # mostly so little that the coefficients need not be looked up
                if squared > (_LITTLE * limit) ** 2 and squared > (
                        limit * self._coefficient(self._body.body_id, contact[3])
                        * self._coefficient(contact[2], contact[4])) ** 2:
                    yield wheel.link

    def _divide(self, wheel: _Wheel, slips: bool) -> None:
        """Divide the load between both links of a wheel, or leave all to the first one."""
        pybullet.setCollisionFilterGroupMask(
            self._body.body_id, wheel.second,
            *(meeting.groups_and_mask(wheel.bitmask) if slips else (0, 0)), **self._client)
        for link in {wheel.link, wheel.second} & self._springs.keys():
            stiffness.set_spring(self._body, link, self._springs[link].scaled(1 / (1 + slips)))
        if not slips:
            pybullet.changeDynamics(self._body.body_id, wheel.link,
                                    anisotropicFriction=[wheel.lowest] * 3, **self._client)

    def _turn(self, wheel: _Wheel) -> None:
        """Set the friction of a wheel that slips for where its axle points."""
        # without numpy, which takes ten times as long for so little
        turned = pybullet.getLinkState(self._body.body_id, wheel.link, computeForwardKinematics=1,
                                       **self._client)[1]
        x, y = _along_floor(turned, wheel.axle)
        # the limits of both of PyBullet's directions add up
        sum_of_both = (abs(x) + abs(y)) / (math.hypot(x, y) or 1.0) or 1.0
        weaker = 1.0
        if wheel.turning is not None and abs(pybullet.getJointState(
                self._body.body_id, wheel.link, **self._client)[1]) < _FAST_RAD_S:
            weaker = math.hypot(*_along_floor(turned, wheel.turning)) / _MEAN_COSINE
        for link, scales, factor in ((wheel.link, wheel.along, 1.0),
                                     (wheel.second, wheel.across, weaker)):
            pybullet.changeDynamics(
                self._body.body_id, link,
                anisotropicFriction=[scale * factor / sum_of_both for scale in scales],
                **self._client)


def _vector(array: np.ndarray) -> Vector:
    x, y, z = array.tolist()
    return x, y, z


def _along_floor(turned: rotations.Quaternion, vector: Vector) -> Tuple[float, float]:
    """Return x and y in the world of a vector in a frame."""
    rows, (x, y, z) = rotations.elements(*turned), vector
    return (rows[0] * x + rows[1] * y + rows[2] * z, rows[3] * x + rows[4] * y + rows[5] * z)
