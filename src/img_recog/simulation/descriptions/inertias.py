"""The mass and inertia of a link, and the nearest inertia that a body can have."""
import xml.etree.ElementTree as ElementTree
from typing import NamedTuple

import numpy as np

from img_recog.simulation.descriptions.geometry import NO_INERTIA, Inertia
from img_recog.simulation.descriptions.numbers import read_number, read_numbers
from img_recog.simulation.descriptions.urdf_elements import INERTIA_KEYS, check_mass, origin_of
from img_recog.simulation.settings import SimulationError

_MAX_MOMENT, _NO_MOMENT = 1e15, 1e-20       # kg m2
# of the largest moment: above what PyBullet's search for the principal axes can miss
_MARGIN = 1e-5
_SAID_FROM = 1e-3                           # of the largest moment: what is told to the user
_RADIUS_OF_GYRATION_M = 0.01                # of a body whose file gives it no moment at all


class Possible(NamedTuple):
    """An inertia (3, 3) in kg m2 that a body can have; warning: how far it is from the given one,
    '' for what makes no difference."""

    matrix: np.ndarray
    warning: str = ''


def read(name: str, link: ElementTree.Element) -> Inertia:
    """Return the inertia of a URDF's link in its frame, NO_INERTIA for one without a mass.

    Raises SimulationError when it is not complete, or a number cannot be used.
    """
    inertial = link.find('inertial')
    if inertial is None:
        return NO_INERTIA
    mass, inertia = inertial.find('mass'), inertial.find('inertia')
    if mass is None or inertia is None:
        raise SimulationError('link {}: <inertial> must have <mass> and <inertia>'.format(name))
    kilograms = read_number('mass of link ' + name, mass.get('value'))
    values = ' '.join(inertia.get(key, '0') for key in INERTIA_KEYS)
    matrix = read_numbers('inertia of link ' + name, values, 9).reshape(3, 3)
    if kilograms == 0:
        return NO_INERTIA
    check_mass('mass of link ' + name, kilograms, ' (or no <inertial>)')
    return Inertia(kilograms, np.zeros(3), matrix).moved(origin_of(inertial))


def possible(name: str, mass: float, matrix: np.ndarray) -> Possible:
    """Return the inertia nearest to `matrix` (3, 3) that a body of `mass` kg can have.

    The principal moments of a body are positive, and none exceeds the sum of the others; PyBullet
    replaces all of them by 0 otherwise, and then the body does not turn at all. name: of the
    body, for the warning.
    Raises SimulationError when a moment is too large to be simulated.
    """
    moments, axes = np.linalg.eigh(matrix)
    if moments[2] > _MAX_MOMENT:
        raise SimulationError('{}: got the moment of inertia {:g} kg m2, expected at most {:g}'
                              .format(name, moments[2], _MAX_MOMENT))
    margin = _MARGIN * moments[2]
    if moments[2] > _NO_MOMENT and moments[0] + moments[1] - moments[2] >= margin:
        return Possible(matrix)
    nearest = _nearest(moments) + margin
    if nearest[2] < _NO_MOMENT:
        nearest = np.full(3, mass * _RADIUS_OF_GYRATION_M ** 2)
    warning = ''
    if np.abs(nearest - moments).max() > _SAID_FROM * nearest[2]:
        warning = ('{}: got the principal moments of inertia {} kg m2; those of a body are more '
                   'than 0, and none exceeds the sum of the others; simulated with {}'.format(
                       name, *(', '.join(map('{:.3g}'.format, each))
                               for each in (moments, nearest))))
    return Possible(axes @ np.diag(nearest) @ axes.T, warning)


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
