"""Puts a body that is in the floor, or in what lies on the floor, onto that.

The physics would throw it into the air, or hold it fast; that of Gazebo lifts it by 1 cm/s.
"""
from typing import List, NamedTuple, Sequence, Set, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.simulation.physics.body import Body

MAX_DEPTH_M = 0.005     # of a contact: the physics lifts a body gently out of less
_TOUCH_M = 1e-4
# Onto anything but the floor, which is infinite. Floors that others have drawn lie some
# centimeters above the ground; what is higher is a wall.
_MAX_RISE_M = 0.3
_STEP_M = 0.01
_FAR_M = 1000.0
_STEEP = 0.7        # vertical part of the normal of a plane: 45 degrees


class Lift(NamedTuple):
    """How far a body was moved upward, in m, and the name of what it stands on; '' at 0 m."""

    height_m: float = 0.0
    onto: str = ''


def lift(body: Body, planes: Sequence[Body], others: Sequence[Body] = ()) -> Lift:
    """Move a body upward, without changing its velocity, until it is in nothing.

    planes: infinite ones, of any height above the body; walls and ceilings among them are left
    out. A body that would still be in one of the others 0.3 m higher is only lifted out of the
    planes. One that is less than MAX_DEPTH_M deep in all of them stays where it is.
    """
    result = Lift()
    for plane in planes:
        depth_m, upward = depth(body, plane), rotations.matrix(plane.pose().orientation)[2, 2]
        if depth_m > MAX_DEPTH_M and upward > _STEEP:
            height_m = depth_m / upward
            result = Lift(result.height_m + height_m, plane.name)
            body.raise_by(height_m)
    near = _within_reach(body, others)
    if any(depth(body, other) > MAX_DEPTH_M for other in near):
        rise = _rise(body, near)
        if rise.onto:
            result = Lift(result.height_m + rise.height_m, rise.onto)
    return result


def first_in_line(body: Body, upward: bool) -> Tuple[int, float]:
    """Return the id of the body straight above the middle of a body, or below it, and its height.

    The id is -1 if there is none.
    """
    low, high = _bounds(body)
    x, y, z = (low + high) / 2
    end = z + (_FAR_M if upward else -_FAR_M)
    while True:         # through the body itself
        (hit,) = pybullet.rayTest((x, y, z), (x, y, end), **body.client)
        if hit[0] != body.body_id:
            return hit[0], hit[3][2]
        z = hit[3][2] + (_TOUCH_M if upward else -_TOUCH_M)


def is_near(body: Body, others: Sequence[Body], distance_m: float) -> bool:
    """Return whether one of the others is at most a distance away from a body."""
    return any(pybullet.getClosestPoints(body.body_id, other.body_id, distance_m, **body.client)
               for other in others)


def depth(body: Body, other: Body) -> float:
    """Return how deep, in m, a body is in another one; 0 when they do not touch."""
    points = pybullet.getClosestPoints(body.body_id, other.body_id, 0.0, **body.client)
    return -min((point[8] for point in points), default=0.0)


def links_in(body: Body, other: Body) -> Set[int]:
    """Return the moving links of a fixed body that are deeper in another body than contacts."""
    points = pybullet.getClosestPoints(body.body_id, other.body_id, 0.0, **body.client)
    return {point[3] for point in points if point[8] < -MAX_DEPTH_M} - body.static_links


def _rise(body: Body, others: Sequence[Body]) -> Lift:
    """Lift a body by the least height at which it touches none of the others.

    Heights are tried, and not computed from the depths of contacts: a mesh is a surface, and the
    shortest way out of it leads down for a body that is for the most part below it.
    """
    height_m, onto = 0.0, ''
    step_m, touched = _STEP_M, _touched(body, others)
    while touched or step_m > _TOUCH_M:
        if not touched:         # look closer, from the height below
            height_m -= step_m
            body.raise_by(-step_m)
            step_m /= 2
        elif height_m > _MAX_RISE_M:
            body.raise_by(-height_m)
            return Lift()
        onto = touched or onto
        height_m += step_m
        body.raise_by(step_m)
        touched = _touched(body, others)
    return Lift(height_m, onto)


def _touched(body: Body, others: Sequence[Body]) -> str:
    """Return the name of the first of the others that a body touches; '' if there is none."""
    return next((other.name for other in others if depth(body, other) > 0), '')


def _within_reach(body: Body, others: Sequence[Body]) -> List[Body]:
    """Return those of the others in which a body is, or can get to be when it is lifted."""
    low, high = _bounds(body)
    high[2] += _MAX_RISE_M + _STEP_M
    return [other for other, bounds in zip(others, map(_bounds, others))
            if np.all(bounds[0] <= high) and np.all(low <= bounds[1])]


def _bounds(body: Body) -> np.ndarray:
    """Return the lowest and the highest corner, (2, 3), of the box around a body."""
    boxes = np.array([pybullet.getAABB(body.body_id, link, **body.client)
                      for link in body.links])
    return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
