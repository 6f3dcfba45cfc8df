"""Rigid transforms and inertias as plain arrays: meters, radians, REP 103 axes."""
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from img_recog import rotations
from img_recog.rotations import Numbers


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


def from_rpy(xyz: Numbers, rpy: Numbers) -> Transform:
    """Return the transform of a URDF <origin>: about fixed axes, roll, then pitch, then yaw.

    >>> np.round(from_rpy((1, 0, 0), (0, 0, np.pi / 2)).apply(np.array((2.0, 0, 0))), 6).tolist()
    [1.0, 2.0, 0.0]
    """
    return Transform(rotations.from_rpy(rpy), np.array(xyz, float))


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
