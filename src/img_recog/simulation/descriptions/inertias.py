"""The masses and inertias that the physics can use."""
import numpy as np

from img_recog.simulation.settings import SimulationError

# kg, kg m2: in PyBullet, a body of 1e300 kg falls through the floor
_MAX_MASS, _MAX_MOMENT = 1e9, 1e15
_MIN = 1e-20


def check_mass(name: str, mass: float, otherwise: str = '') -> None:
    """Raise SimulationError unless a mass in kg can be used; otherwise: what else is allowed.

    >>> check_mass('mass of link a', 0.0)
    Traceback (most recent call last):
    img_recog.simulation.settings.SimulationError: mass of link a: got 0 kg, expected more than 0
    """
    if not _MIN <= mass <= _MAX_MASS:
        limit = 'more than 0' if mass < _MIN else 'at most {:g}'.format(_MAX_MASS)
        raise SimulationError('{}: got {:g} kg, expected {}{}'.format(
            name, mass, limit, otherwise))


def check_moments(name: str, inertia: np.ndarray) -> None:
    """Raise SimulationError unless an inertia (3, 3) in kg m2 can be simulated."""
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] < _MIN or moments[2] > _MAX_MOMENT:
        raise SimulationError('{} has the inertia {}, expected {}'.format(
            name, np.round(np.diag(inertia), 9).tolist(), 'positive moments about all axes'
            if moments[0] < _MIN else 'moments of at most {:g} kg m2'.format(_MAX_MOMENT)))
