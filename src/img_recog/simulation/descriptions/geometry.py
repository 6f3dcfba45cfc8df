"""Rigid transforms and inertias as plain arrays: meters, radians, REP 103 axes."""
import math
from dataclasses import dataclass
from typing import NamedTuple, Sequence, Tuple, Union

import numpy as np

Numbers = Union[Sequence[float], np.ndarray]


class Transform(NamedTuple):
    """A pose of a child frame in its parent: `rotation` (3, 3), `translation` (3,) in meters."""

    rotation: np.ndarray
    translation: np.ndarray

    def __matmul__(self, other: 'Transform') -> 'Transform':
        return Transform(self.rotation @ other.rotation, self.apply(other.translation))

    @property
    def inverse(self) -> 'Transform':
        """The pose of the parent in the child frame."""
        # not by np.linalg, which wakes the threads of OpenBLAS: they wait in a loop afterwards
        return Transform(self.rotation.T, -self.rotation.T @ self.translation)

    def apply(self, point: np.ndarray) -> np.ndarray:
        """Return `point`, given in the child frame, in the parent frame."""
        return self.rotation @ point + self.translation

    def matrix(self) -> np.ndarray:
        """Return it as a homogeneous transform (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self
        return matrix


IDENTITY = Transform(np.eye(3), np.zeros(3))


def from_rpy(xyz: Numbers, rpy: Numbers) -> Transform:
    """Return the transform of a URDF <origin>: about fixed axes, roll, then pitch, then yaw."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    rotation = np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                         [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                         [-sp, cp * sr, cp * cr]])
    return Transform(rotation, np.array(xyz, float))


def to_rpy(rotation: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw of a rotation matrix, the inverse of `from_rpy`."""
    horizontal = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], horizontal)
    if horizontal < 1e-9:       # gimbal lock: only the sum of roll and yaw is defined
        return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
    return np.array([math.atan2(rotation[2, 1], rotation[2, 2]), pitch,
                     math.atan2(rotation[1, 0], rotation[0, 0])])


def to_quaternion(rotation: np.ndarray) -> Tuple[float, float, float, float]:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix (3, 3)."""
    # 4 times the squares of w, x, y, z; the largest one is divided by
    m = rotation
    squares = (1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
               1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2])
    largest = int(np.argmax(squares))
    rows = ((squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
            (m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]),
            (m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]),
            (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]))
    scale = 2 * math.sqrt(squares[largest])
    w, x, y, z = (float(value) / scale for value in rows[largest])
    return x, y, z, w


@dataclass(frozen=True)
class Inertia:
    """Mass in kg, center of mass (3,) in m, and inertia (3, 3) in kg m2 about that center."""

    mass: float
    center: np.ndarray
    matrix: np.ndarray

    def moved(self, frame: Transform) -> 'Inertia':
        """Return this inertia, given in `frame`, in the parent of `frame`."""
        return Inertia(self.mass, frame.apply(self.center),
                       frame.rotation @ self.matrix @ frame.rotation.T)

    def __add__(self, other: 'Inertia') -> 'Inertia':
        mass = self.mass + other.mass
        if mass == 0:
            return NO_INERTIA
        center = (self.mass * self.center + other.mass * other.center) / mass
        return Inertia(mass, center, self._about(center) + other._about(center))

    def _about(self, point: np.ndarray) -> np.ndarray:
        """Return the inertia matrix about `point` (the parallel axis theorem)."""
        arm = self.center - point
        return self.matrix + self.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


NO_INERTIA = Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
