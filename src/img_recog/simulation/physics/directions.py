"""Friction along and across wheels whose files give a direction of it.

In ODE, the pyramid of friction turns with the wheel. In PyBullet, it stays along the axes of the
world. PyBullet can scale friction along the axes of a link, and with a scale of 0 along one of
them, both sides of the pyramid become the same. So there are two links with the same treads, which
share the load: one has friction around the wheel, the other one along its axle.
"""
import math
from typing import Dict, NamedTuple, Optional

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.model import Friction, Joint
from img_recog.simulation.physics.body import Vector
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.tires import ACROSS, wheel_of

_PARALLEL = 0.7
# A faster wheel turns too far between two updates. The mean over a turn is used.
_FAST_RAD_S, _MEAN_COSINE = 30.0, 2 / math.pi
_SLIPS_M_S = 0.01       # a contact of ODE pushes a wheel out with this speed, so less is no slip
_MAX_LOAD = 20.0        # ODE has no limit: the wheel jams


class _Wheel(NamedTuple):
    """A wheel in PyBullet.

    Attributes:
        radius: Radius in m.
        mu: Coefficient of friction along the direction.
        axle: Unit vector (3,), in the frame of the center of mass of each tread.
        turning: The direction of friction (3,) in that frame if it turns with the wheel, with its
            length in the file.
        scales: Scales (3,) of friction along the axes of that frame, by PyBullet's index of the
            link with the tread.
    """

    radius: float
    mu: float
    axle: Vector
    turning: Optional[Vector]
    scales: Dict[int, Vector]


class Directions:
    """The wheels of a body that have a direction of friction; false if there are none."""

    def __init__(self, body: FramedBody):
        self._body, self._client = body, body.client
        surfaces = {link.name: link.surface for link in body.model.links}
        wheels = {wheel_of(name) for name in body.link_indices if name.endswith(ACROSS)}
        self._wheels = [self._wheel(joint, surfaces[joint.child])
                        for joint in body.model.joints if joint.child in wheels]

    def __bool__(self) -> bool:
        return bool(self._wheels)

    def _wheel(self, joint: Joint, friction: Friction) -> _Wheel:
        indices = self._body.link_indices
        direction, axle = np.array(friction.direction), np.asarray(joint.axis)
        length = np.linalg.norm(direction)
        treads = {name: index for name, index in indices.items()
                  if name != joint.child and wheel_of(name) == joint.child}
        turn = rotations.matrix(pybullet.getDynamicsInfo(
            self._body.body_id, next(iter(treads.values())), **self._client)[4]).T
        is_axle = np.abs(turn @ axle) > _PARALLEL
        is_along_axle = abs(axle @ direction) > _PARALLEL * length
        # ODE takes the direction with its length, by which both forces grow
        coefficients = (length * np.array((friction.mu, friction.across)) if is_along_axle
                        else (friction.mu, friction.across))
        around, across = coefficients[::-1] if is_along_axle else coefficients
        half = 2 / (friction.largest or 1.0)        # each of two links has half of the load
        radius = max(pybullet.getCollisionShapeData(
            self._body.body_id, index, **self._client)[0][3][1] for index in treads.values())
        return _Wheel(radius, friction.mu, (turn @ axle).tolist(),
                      None if is_along_axle else (turn @ direction).tolist(), {
                          index: (np.where(is_axle, across * half, 0.0)
                                  if name.endswith(ACROSS) else
                                  np.where(is_axle, 0.0, around * half)).tolist()
                          for name, index in treads.items()})

    def update(self) -> None:
        """Set the friction for the headings of the wheels. Call it every few steps."""
        for wheel in self._wheels:
            self._set(wheel)

    def _set(self, wheel: _Wheel) -> None:
        # without numpy, which takes ten times as long for so little
        body_id, client = self._body.body_id, self._client
        state = pybullet.getLinkState(body_id, next(iter(wheel.scales)), computeLinkVelocity=1,
                                      computeForwardKinematics=1, **client)
        turned, (speed_x, speed_y, _), (turn_x, turn_y, _) = state[1], state[6], state[7]
        x, y, _ = _rotated(turned, wheel.axle)
        # the limits of both of PyBullet's directions add up
        factor = (math.hypot(x, y) or 1.0) / (abs(x) + abs(y) or 1.0)
        if wheel.turning is not None:
            # In ODE, the direction also points up and down while the wheel turns. Its horizontal
            # part is friction. Its vertical part is a load on the wheel, or lifts it.
            x, y, z = _rotated(turned, wheel.turning)
            slip = x * (speed_x - turn_y * wheel.radius) + y * (speed_y + turn_x * wheel.radius)
            share = max(-1.0, min(slip / _SLIPS_M_S, 1.0))
            factor *= (_MEAN_COSINE * math.sqrt(x * x + y * y + z * z)
                       if math.hypot(turn_x, turn_y) > _FAST_RAD_S
                       else math.hypot(x, y) / max(1 - share * wheel.mu * z, 1 / _MAX_LOAD))
        for link, scales in wheel.scales.items():
            pybullet.changeDynamics(
                body_id, link, anisotropicFriction=[scale * factor for scale in scales], **client)


def _rotated(turned: rotations.Quaternion, vector: Vector) -> Vector:
    """Return a vector in the world, given the rotation of its frame."""
    rows, (x, y, z) = rotations.elements(*turned), vector
    return (rows[0] * x + rows[1] * y + rows[2] * z, rows[3] * x + rows[4] * y + rows[5] * z,
            rows[6] * x + rows[7] * y + rows[8] * z)
