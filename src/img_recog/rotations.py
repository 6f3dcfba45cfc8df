"""Rotations as matrices (3, 3), as quaternions x, y, z, w, and as roll, pitch and yaw; poses.

A matrix turns vectors of the child frame into the parent's.
"""
import math
from typing import Any, List, NamedTuple, Sequence, Tuple, Union

import numpy as np

Quaternion = Tuple[float, float, float, float]      # x, y, z, w
Numbers = Union[Sequence[float], np.ndarray]


def elements(x: Any, y: Any, z: Any, w: Any) -> Tuple[Any, ...]:
    """Return the nine elements of the matrix of a quaternion, row by row.

    x, y, z, w: of any length but zero; numbers, or arrays for many quaternions.

    >>> elements(0.0, 0.0, 0.0, 2.0)
    (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    """
    scale = 2 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * scale, y * scale, z * scale
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz = x * xs, x * ys, x * zs
    yy, yz, zz = y * ys, y * zs, z * zs
    return (1 - (yy + zz), xy - wz, xz + wy,
            xy + wz, 1 - (xx + zz), yz - wx,
            xz - wy, yz + wx, 1 - (xx + yy))


def matrix(quaternion: Numbers) -> np.ndarray:
    """Return the matrix of a quaternion of any length but zero.

    >>> (matrix((0, 0, 1, 1)) @ (1, 0, 0)).tolist()     # a quarter turn to the left
    [0.0, 1.0, 0.0]
    """
    return np.array(elements(*quaternion)).reshape(3, 3)


def into_frame(quaternion: Quaternion, *vectors: Sequence[float]) -> List[Tuple[float, ...]]:
    """Return vectors of the parent frame in the child frame, which has that orientation.

    >>> into_frame((0.0, 0.0, 1.0, 1.0), (1.0, 0.0, 5.0))
    [(0.0, -1.0, 5.0)]
    """
    # plain numbers: for three of them, arrays take several times as long
    xx, yx, zx, xy, yy, zy, xz, yz, zz = elements(*quaternion)
    return [(xx * x + xy * y + xz * z, yx * x + yy * y + yz * z, zx * x + zy * y + zz * z)
            for x, y, z in vectors]


def yaw(quaternion: Quaternion) -> float:
    """Return the heading of a quaternion of any length but zero, from -pi to pi.

    >>> yaw((0, 0, 3, 3)) == math.pi / 2
    True
    """
    x, y, z, w = quaternion
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def of_yaw(angle: float) -> Quaternion:
    """Return the unit quaternion of a turn about z.

    >>> of_yaw(math.pi)[:3]
    (0.0, 0.0, 1.0)
    """
    return 0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)


def quaternion_of(rotation: np.ndarray) -> Quaternion:
    """Return the unit quaternion of a matrix.

    >>> quaternion_of(np.diag([1, -1, -1]))     # half a turn about x
    (1.0, 0.0, 0.0, 0.0)
    """
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


def from_rpy(rpy: Numbers) -> np.ndarray:
    """Return the matrix of a URDF's roll, pitch and yaw: about fixed axes, in this order.

    >>> (from_rpy((math.pi / 2, 0, math.pi / 2)) @ (0, 1, 0)).round().astype(int).tolist()
    [0, 0, 1]
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def to_rpy(rotation: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw of a matrix, the inverse of `from_rpy`.

    >>> to_rpy(from_rpy((0.1, 0.2, 0.3))).round(9).tolist()
    [0.1, 0.2, 0.3]
    """
    horizontal = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], horizontal)
    if horizontal < 1e-9:       # gimbal lock: only the sum of roll and yaw is defined
        return np.array([math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0])
    return np.array([math.atan2(rotation[2, 1], rotation[2, 2]), pitch,
                     math.atan2(rotation[1, 0], rotation[0, 0])])


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
        """Return `point`, given in the child frame, in the parent frame.

        >>> raised = Transform(np.eye(3), np.array((0.0, 0.0, 0.1)))
        >>> raised.apply(np.array((1.0, 0.0, 0.0))).tolist()
        [1.0, 0.0, 0.1]
        """
        return self.rotation @ point + self.translation

    def matrix(self) -> np.ndarray:
        """Return it as a homogeneous transform (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self
        return matrix


IDENTITY = Transform(np.eye(3), np.zeros(3))


def transform(xyz: Numbers, rpy: Numbers) -> Transform:
    """Return the pose of a URDF <origin>: about fixed axes, roll, then pitch, then yaw.

    >>> np.round(transform((1, 0, 0), (0, 0, np.pi / 2)).apply(np.array((2.0, 0, 0))), 6).tolist()
    [1.0, 2.0, 0.0]
    """
    return Transform(from_rpy(rpy), np.array(xyz, float))
