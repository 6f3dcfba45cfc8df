"""Rays against boxes, cylinders, spheres and the floor, all at once.

PyBullet tests each ray against each shape that it may hit by an iteration, which ends within a
millimetre and takes five times as long for a scan. Here the distances are those of the geometry.
"""
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.rotations import Quaternion
from img_recog.simulation.physics.body import Vector
from img_recog.simulation.physics.client import Pose, body_ids, center, link_indices
from img_recog.simulation.physics.tires import TREAD

_BOX, _CYLINDER, _SPHERE, _PLANE = (pybullet.GEOM_BOX, pybullet.GEOM_CYLINDER,
                                    pybullet.GEOM_SPHERE, pybullet.GEOM_PLANE)
_UP = (0.0, 0.0, 1.0)           # the normal of a floor
_TINY = 1e-300                  # in place of 0 in a divisor: the quotient is large but a number
_Part = Tuple[int, int]         # body and link, -1 for the base
_Poses = Dict[_Part, Pose]


class Bundles(NamedTuple):
    """Bundles of rays; those of a bundle start at the same point.

    starts (n, 3): m; directions (n, rays, 3): unit vectors; both in the world. shortest (n,): m, a
    ray does not see what is nearer; longest (n,): bodies that are farther away may be missed.
    """

    starts: np.ndarray
    directions: np.ndarray
    shortest: np.ndarray
    longest: np.ndarray


class _Shape(NamedTuple):
    """A shape in the frame of the center of mass of its part.

    kind and size: those of pybullet.getCollisionShapeData.
    """

    part: _Part
    kind: int
    size: Vector
    position: Vector
    orientation: Quaternion


class Solids:
    """The collision shapes of all bodies in a physics client.

    As in Gazebo, a ray that begins in a shape ends on its inner side. others: the ids of bodies of
    other kinds, whose shapes PyBullet does not tell.
    """

    def __init__(self, physics_client_id: int):
        self._client = physics_client_id
        self.others: Set[int] = set()
        self._bodies: Optional[Tuple[int, ...]] = None
        self._shapes: List[_Shape] = []
        self._are_all = True
        self._poses: _Poses = {}
        self._groups: Dict[int, _Group] = {}

    def forget(self) -> None:
        """Call after a body was added or removed: PyBullet uses the ids of bodies again."""
        self._bodies = None

    def distances(self, bundles: 'Bundles') -> Tuple[np.ndarray, bool]:
        """Return how far each ray goes until it hits a box, cylinder, sphere or floor, (bundles,
        rays), inf if it does not; and whether there are shapes of other kinds.
        """
        self._refresh()
        nearest = np.full(bundles.directions.shape[:2], np.inf)
        for group in self._groups.values():
            group.shorten(nearest, bundles)
        return nearest, not self._are_all

    def _refresh(self) -> None:
        """Take note of bodies that were added, removed or moved."""
        client = self._client
        bodies = body_ids(client)
        if bodies != self._bodies:
            self._bodies = bodies
            shapes = _shapes(bodies, client)
            self._shapes = [shape for shape in shapes if shape.kind in _GROUPS
                            and (shape.kind != _PLANE or shape.size == _UP)]
            self._are_all = len(self._shapes) == len(shapes) and not self.others & set(bodies)
            self._poses, self._groups = {}, {}
            for kind in sorted({shape.kind for shape in self._shapes}):
                self._groups[kind] = _GROUPS[kind](
                    [shape for shape in self._shapes if shape.kind == kind])
        poses = {part: center(*part, client) for part in {shape.part for shape in self._shapes}}
        moved = {part: pose for part, pose in poses.items() if self._poses.get(part) != pose}
        self._poses = poses
        for group in self._groups.values():
            group.place(moved)


def _shapes(bodies: Sequence[int], client: int) -> List[_Shape]:
    return [_Shape((body, link), kind, size, position, orientation)
            for body in bodies
            # those of a second link of a wheel are where those of the first one are
            for name, link in link_indices(body, client).items() if TREAD not in name
            for _, _, kind, size, _, position, orientation in pybullet.getCollisionShapeData(
                body, link, physicsClientId=client)]


class _Group:
    """Shapes of one kind."""

    def __init__(self, shapes: Sequence[_Shape]):
        """`place` must come next, for all parts."""
        self._shapes = shapes
        self._positions = np.empty((len(shapes), 3))
        # (axes of a shape, shapes, axes of the world): the inverse rotations
        self._rotations = np.empty((3, len(shapes), 3))
        # (axes, shapes, 1)
        self._sizes = np.array([shape.size for shape in shapes]).T[:, :, None]
        self._reaches = self._reach()

    def place(self, poses: _Poses) -> None:
        """Move the shapes of some parts."""
        for number, shape in enumerate(self._shapes):
            if shape.part in poses:
                position, orientation = pybullet.multiplyTransforms(
                    *poses[shape.part], shape.position, shape.orientation)
                self._positions[number] = position
                self._rotations[:, number] = rotations.matrix(orientation).T

    def shorten(self, nearest: np.ndarray, bundles: Bundles) -> None:
        """Reduce distances (bundles, rays) to those of the shapes that the rays hit."""
        # (bundles, shapes, axes)
        offsets = bundles.starts[:, None] - self._positions
        near = np.sqrt((offsets * offsets).sum(axis=-1)) <= (
            bundles.longest[:, None] + self._reaches)
        for number, is_near in enumerate(near):
            shapes = np.flatnonzero(is_near)
            if not len(shapes):
                continue
            # in the frames of the shapes, axis by axis: (axes, shapes, 1), (axes, shapes, rays)
            rotations = self._rotations[:, shapes]
            starts = (rotations * offsets[number, shapes]).sum(axis=-1, keepdims=True)
            turned = (rotations.reshape(-1, 3) @ bundles.directions[number].T).reshape(
                3, len(shapes), -1)
            enter, leave = self._interval(self._sizes[:, shapes], starts, turned)
            shortest = bundles.shortest[number]
            # of a line that misses the shape, it begins after its end
            surface = np.where(enter > shortest, enter, leave)
            hit = (enter <= leave) & (surface > shortest)
            np.minimum(nearest[number], np.where(hit, surface, np.inf).min(axis=0),
                       out=nearest[number])

    def _reach(self) -> np.ndarray:
        """Return how far each shape reaches at most from its middle, (shapes,)."""
        return np.full(len(self._positions), np.inf)

    def _interval(self, sizes: np.ndarray, starts: np.ndarray, directions: np.ndarray
                  ) -> Tuple[np.ndarray, np.ndarray]:
        """Return where the line of each ray is in each shape, from and to; (shapes, rays)."""
        raise NotImplementedError


class _Boxes(_Group):
    def _reach(self):
        return np.sqrt((self._sizes[..., 0] ** 2).sum(axis=0)) / 2

    def _interval(self, sizes, starts, directions):
        return _slabs(starts, directions, sizes / 2)


class _Spheres(_Group):
    def _reach(self):
        return self._sizes[0, :, 0]

    def _interval(self, sizes, starts, directions):
        return _round(starts, directions, sizes[0])


class _Cylinders(_Group):
    def _reach(self):
        length, radius = self._sizes[:2, :, 0]
        return np.hypot(length / 2, radius)

    def _interval(self, sizes, starts, directions):
        length, radius = sizes[:1], sizes[1]
        enter, leave = _round(starts[:2], directions[:2], radius)
        bottom, top = _slabs(starts[2:], directions[2:], length / 2)
        return np.maximum(enter, bottom), np.minimum(leave, top)


class _Planes(_Group):
    def _interval(self, sizes, starts, directions):
        height, slope = starts[2], directions[2]
        # seen from below too, like in Gazebo; a ray along it never meets it
        enter = np.where(slope, -height / np.where(slope, slope, 1), np.inf)
        return enter, enter


_GROUPS = {_BOX: _Boxes, _CYLINDER: _Cylinders, _SPHERE: _Spheres, _PLANE: _Planes}


def _slabs(starts: np.ndarray, directions: np.ndarray, halves: np.ndarray
           ) -> Tuple[np.ndarray, np.ndarray]:
    """Return where lines are between the planes at -half and half of all of their axes."""
    enter: Any = -np.inf
    leave: Any = np.inf
    for start, direction, half in zip(starts, directions, halves):
        inverse = 1 / np.where(direction, direction, _TINY)
        first, second = (-half - start) * inverse, (half - start) * inverse
        enter = np.maximum(enter, np.minimum(first, second))
        leave = np.minimum(leave, np.maximum(first, second))
    return enter, leave


def _round(starts: np.ndarray, directions: np.ndarray, radius: np.ndarray
           ) -> Tuple[np.ndarray, np.ndarray]:
    """Return where lines are within a radius of the origin, on as many axes as they have."""
    square: Any = 0
    half: Any = 0
    for start, direction in zip(starts, directions):
        square = square + direction * direction
        half = half + start * direction
    square = np.maximum(square, _TINY)
    discriminant = half * half - square * ((starts * starts).sum(axis=0) - radius * radius)
    root = np.sqrt(np.maximum(discriminant, 0))
    # of a line that is never so near, the end is before the begin
    enter = np.where(discriminant >= 0, -half - root, np.inf) / square
    return enter, (root - half) / square
