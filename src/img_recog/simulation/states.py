"""The state of a model or link in a reference frame, as it is read and set."""
from typing import NamedTuple, Sequence

import numpy as np

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.rotations import Quaternion, Transform
from img_recog.simulation.physics.body import Motion

# m, m/s, N: far beyond this PyBullet computes NaN, and the floor carries nothing from then on
_MAX_VALUE = 1e6


class State(NamedTuple):
    """Pose and velocity of a model or link in a reference frame: m, unit quaternion (x, y, z, w),
    m/s, rad/s.

    Like in Gazebo, a quaternion of zeros that is given is no rotation.
    """

    position: Sequence[float]
    orientation: Quaternion
    linear: Sequence[float]
    angular: Sequence[float]

    def pose(self) -> Transform:
        """Return the pose in the reference frame."""
        turn = self.orientation if np.linalg.norm(self.orientation) > 1e-6 else (0, 0, 0, 1)
        return Transform(rotations.matrix(turn), np.array(self.position, float))

    def check(self) -> None:
        """Raise SimulationError when a number is too large or not finite."""
        check('state', np.concatenate([np.array(part, float) for part in self]))


REST = State((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def in_world(motion: Motion) -> State:
    """Return the state in the world of what moves so."""
    turn = rotations.matrix(motion.orientation)
    return State(motion.position.tolist(), motion.orientation, turn @ motion.linear,
                 turn @ motion.angular)


def check(what: str, values: Sequence[float]) -> None:
    """Raise SimulationError, naming what they are, when numbers are too large or not finite."""
    given = np.array(values, float)
    if not np.all(np.isfinite(given)):
        raise SimulationError('{}: got {}, expected finite numbers'.format(what, given.tolist()))
    if np.abs(given).max(initial=0.0) > _MAX_VALUE:
        raise SimulationError('{0}: got {1}, expected numbers from -{2:g} to {2:g}'.format(
            what, given.tolist(), _MAX_VALUE))
