"""How long the next step of the physics takes, where bodies touch in many points.

PyBullet's solver copies all points that it has for each one that is new: the time grows with their
square.
"""
import math
from typing import Iterator, Sequence

import pybullet

from img_recog.errors import SimulationError, shortened
from img_recog.report import NOTE, Report
from img_recog.simulation.physics.body import Body

_LONG_S = 1.0
# measured while other programs ran: 64 free boxes in one place, each with 6 degrees of freedom and
# 252 points; alone, 4 s
_MAX_S, _MAX = 10.0, 64 * 6 * 252
_MAX_NEAR = 20000       # the points of more would take too much memory
_SHOWN = 3              # bodies in a line


def check(bodies: Sequence[Body], report: Report) -> None:
    """Look for bodies that touch so often that the next step takes long.

    report: gets a line if it takes more than 1 s.
    Raises SimulationError if it takes more than 10 s.
    """
    moving = [body for body in bodies if not body.fixed or body.joints]
    if not moving:
        return
    near = []
    for body in moving:
        near.append(sum(other != body.body_id for other in near_bodies(body)))
        if sum(near) > _MAX_NEAR:
            break
    time_s = math.inf
    crowded = [body for count, body in zip(near, moving) if count]
    reason = 'more than {} pairs of bodies are in one place, the first are {}'.format(
        _MAX_NEAR // 2, ', '.join(shortened(body.name) for body in crowded[:_SHOWN]))
    if sum(near) <= _MAX_NEAR:
        client = {'physicsClientId': moving[0].physics_client_id}
        pybullet.performCollisionDetection(**client)
        points = [len(pybullet.getContactPoints(body.body_id, **client)) for body in moving]
        time_s = _MAX_S * (sum(count * (len(body.joints) + 6 * (not body.fixed))
                               for count, body in zip(points, moving)) / _MAX) ** 2
        most = sorted(zip(points, moving), key=lambda each: -each[0])[:_SHOWN]
        reason = 'bodies touch or overlap in many points, {}'.format(', '.join(
            '{} in {}'.format(shortened(body.name), count) for count, body in most))
    if time_s > _MAX_S:
        raise SimulationError(
            'the next step of the physics would take more than {:.0f} s: {}'.format(
                _MAX_S, reason),
            'move them apart, join the links of a model by fixed joints, or make it static')
    if time_s >= _LONG_S:
        report.add(NOTE, 'the next step of the physics takes about {:.0f} s: {}'.format(
            time_s, reason))


def near_bodies(body: Body, margin_m: float = 0.0) -> Iterator[int]:
    """Yield PyBullet's number of the body of each link near a link of a body, also of itself.

    margin_m: how far the boxes around the links of the body are enlarged.
    """
    for link in body.links:
        low, high = pybullet.getAABB(body.body_id, link, **body.client)
        yield from (other for other, _ in pybullet.getOverlappingObjects(
            [value - margin_m for value in low], [value + margin_m for value in high],
            **body.client) or ())
