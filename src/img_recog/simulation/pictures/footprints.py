"""The outlines of what stands in a world, seen from above."""
import math
from typing import Iterator, List, Optional

import cv2
import numpy as np
import pybullet

from img_recog import rotations
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.world import World

_CIRCLE_CORNERS = 24
_UNIT_BOX = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def footprints(world: World) -> List[np.ndarray]:
    """Return the outline (corners, 2) in m of each collision shape of the bodies in the world.

    An outline is the convex hull of the shape seen along z. Meshes, terrain and planes are
    skipped; robots are not part of the world.
    """
    return [outline for body in world.scenery if not body.is_terrain
            for outline in _outlines(body)]


def _outlines(body: Body) -> Iterator[np.ndarray]:
    for link in body.links:
        for shape in pybullet.getCollisionShapeData(body.body_id, link, **body.client):
            points = _hull_points(shape[2], shape[3])
            if points is not None:
                position, orientation = pybullet.multiplyTransforms(*body.center(link),
                                                                    *shape[5:7])
                yield _convex_hull(
                    (points @ rotations.matrix(orientation).T + position)[:, :2])


def _hull_points(shape_type: int, size: tuple) -> Optional[np.ndarray]:
    """Return points (n, 3) with the convex hull of a shape, in its frame; None for other types.

    size: the dimensions that pybullet.getCollisionShapeData gives.
    """
    angles = np.arange(_CIRCLE_CORNERS) * 2 * math.pi / _CIRCLE_CORNERS
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(_CIRCLE_CORNERS)], axis=1)
    if shape_type == pybullet.GEOM_BOX:
        return _UNIT_BOX * size
    if shape_type == pybullet.GEOM_CYLINDER:
        height, radius = size[:2]
        return np.concatenate([rim * radius + (0, 0, end * height) for end in (-0.5, 0.5)])
    if shape_type == pybullet.GEOM_SPHERE:
        # a circle about each axis: seen along any of them it is one
        return np.concatenate([np.roll(rim, turn, axis=1) for turn in range(3)]) * size[0]
    return None


def _convex_hull(points: np.ndarray) -> np.ndarray:
    """Return the corners (n, 2) of the convex hull of points (m, 2), anticlockwise."""
    points = points.round(6)
    # OpenCV computes in single precision, which is finer near the origin
    near_origin = (points - points[0]).astype(np.float32)
    return points[cv2.convexHull(near_origin, returnPoints=False)[:, 0]]
