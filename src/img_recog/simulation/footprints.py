"""What stands in a world, seen from above."""
import math
from typing import Iterator, List

import numpy as np
import pybullet

from img_recog.simulation.body import Body, rotation_matrix
from img_recog.simulation.world import World

_CORNERS = 24                   # of what is round
_BOX = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def footprints(world: World) -> List[np.ndarray]:
    """Return the outline (corners, 2) in m of each collision shape of the bodies in the world.

    An outline is the convex hull of the shape seen along z. Left out are meshes and planes, and
    the robots, which are not the world's.
    """
    return [outline for body in world.bodies for outline in _of_body(body)]


def _of_body(body: Body) -> Iterator[np.ndarray]:
    for link in body.links:
        if link == -1:
            frame = pybullet.getBasePositionAndOrientation(body.number,
                                                           physicsClientId=body.client)
        else:
            frame = pybullet.getLinkState(body.number, link, physicsClientId=body.client)[:2]
        for shape in pybullet.getCollisionShapeData(body.number, link,
                                                    physicsClientId=body.client):
            points = _points(shape[2], shape[3])
            if points is not None:
                position, orientation = pybullet.multiplyTransforms(*frame, *shape[5:7])
                yield _hull((points @ rotation_matrix(orientation).T + position)[:, :2])


def _points(kind: int, size: tuple):
    """Return points (n, 3) in the shape's frame whose hull is the shape's, None for others."""
    angles = np.arange(_CORNERS) * 2 * math.pi / _CORNERS
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(_CORNERS)], axis=1)
    if kind == pybullet.GEOM_BOX:
        return _BOX * size
    if kind == pybullet.GEOM_CYLINDER:
        height, radius = size[:2]
        return np.concatenate([rim * radius + (0, 0, end * height) for end in (-0.5, 0.5)])
    if kind == pybullet.GEOM_SPHERE:
        # the same from all sides: a rim about each axis
        return np.concatenate([np.roll(rim, turn, axis=1) for turn in range(3)]) * size[0]
    return None


def _hull(points: np.ndarray) -> np.ndarray:
    """Return the corners (n, 2) of the convex hull of points (m, 2), anticlockwise."""
    ordered = sorted(map(tuple, points.round(6).tolist()))
    halves = []
    for way in (ordered, ordered[::-1]):
        half: list = []
        for x, y in way:
            while len(half) > 1 and ((half[-1][0] - half[-2][0]) * (y - half[-2][1])
                                     <= (half[-1][1] - half[-2][1]) * (x - half[-2][0])):
                half.pop()
            half.append((x, y))
        halves += half[:-1]
    return np.array(halves)
