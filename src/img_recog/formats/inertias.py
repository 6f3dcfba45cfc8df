"""Which mass a link can have, and the nearest inertia that a body can have."""
import numpy as np

from img_recog.errors import SimulationError
from img_recog.report import Report

INERTIA_KEYS = ('ixx', 'ixy', 'ixz', 'ixy', 'iyy', 'iyz', 'ixz', 'iyz', 'izz')   # row by row
# kg: in PyBullet, a body of 1e300 kg falls through the floor
_MIN_MASS, _MAX_MASS = 1e-20, 1e9
_MAX_MOMENT, _NO_MOMENT = 1e15, 1e-20       # kg m2
# of the largest moment: above what PyBullet's search for the principal axes can miss
_MARGIN = 1e-5
_SAID_FROM = 1e-3                           # of the largest moment: what is told to the user
_RADIUS_OF_GYRATION_M = 0.01                # of a body whose file gives it no moment at all


def check_mass(name: str, mass: float, otherwise: str = '') -> None:
    """Raise SimulationError unless a mass in kg can be used; otherwise: what else is allowed.

    >>> check_mass('mass of link a', 0.0)
    Traceback (most recent call last):
    img_recog.errors.SimulationError: mass of link a: got 0 kg, expected more than 0
    """
    if not _MIN_MASS <= mass <= _MAX_MASS:
        limit = 'more than 0' if mass < _MIN_MASS else 'at most {:g}'.format(_MAX_MASS)
        raise SimulationError('{}: got {:g} kg, expected {}{}'.format(
            name, mass, limit, otherwise))


def possible(name: str, mass: float, matrix: np.ndarray, report: Report) -> np.ndarray:
    """Return the inertia nearest to `matrix` (3, 3) that a body of `mass` kg can have.

    The principal moments of a body are positive, and none exceeds the sum of the others; PyBullet
    replaces all of them by 0 otherwise, and then the body does not turn at all. name: of the
    body; report: gets a finding if the inertia that is returned makes a difference.
    Raises SimulationError when a moment is too large to be simulated.
    """
    moments, axes = np.linalg.eigh(matrix)
    if moments[2] > _MAX_MOMENT:
        raise SimulationError('{}: got the moment of inertia {:g} kg m2, expected at most {:g}'
                              .format(name, moments[2], _MAX_MOMENT))
    margin = _MARGIN * moments[2]
    if moments[2] > _NO_MOMENT and moments[0] + moments[1] - moments[2] >= margin:
        return matrix
    nearest = _nearest(moments) + margin
    if nearest[2] < _NO_MOMENT:
        nearest = np.full(3, mass * _RADIUS_OF_GYRATION_M ** 2)
    if np.abs(nearest - moments).max() > _SAID_FROM * nearest[2]:
        report.assume('inertia of {}: the nearest possible one'.format(name), (
            '{}: got the principal moments of inertia {} kg m2; those of a body are more than 0, '
            'and none exceeds the sum of the others; simulated with {}'.format(
                name, *(', '.join(map('{:.3g}'.format, each)) for each in (moments, nearest)))))
    return axes @ np.diag(nearest) @ axes.T


def _nearest(moments: np.ndarray) -> np.ndarray:
    """Return the moments nearest to those given, in rising order, of which none exceeds the sum
    of the others.

    They form a cone: the sums of the rays (0, 1, 1), (1, 0, 1) and (1, 1, 0).
    """
    excess = max(moments[2] - moments[0] - moments[1], 0.0)
    on_plane = moments + np.array((excess, excess, -excess)) / 3
    if on_plane[0] >= 0:
        return on_plane
    return np.array((0.0, 1.0, 1.0)) * max((moments[1] + moments[2]) / 2, 0.0)
