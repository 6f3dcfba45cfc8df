"""The numbers of XML elements."""
import math
import re
from typing import Iterable, Optional

import numpy as np

from img_recog.errors import SimulationError
from img_recog.settings import computable

_MAX_LENGTH = 1e6
_INFINITE = re.compile('[-+]?inf(inity)?', re.IGNORECASE)
_WHOLE = re.compile(r'\s*([-+]?)(0[xX][0-9a-fA-F]+|[0-9]{1,9}(?![0-9]))')


def read_numbers(name: str, text: Optional[str], count: int) -> np.ndarray:
    """Return `count` finite numbers, those that are `computable`.

    Raises SimulationError naming what they are if the text is something else.

    >>> read_numbers('xyz of link a', '0 -1.5 2', 3).tolist()
    [0.0, -1.5, 2.0]
    """
    return np.array([computable(value) for value in _finite(name, text, count).tolist()])


def _finite(name: str, text: Optional[str], count: int) -> np.ndarray:
    try:
        values = np.array([float(word) for word in (text or '').split()])
    except ValueError:
        values = np.array([])
    if len(values) != count or not all(math.isfinite(value) for value in values):
        raise SimulationError('{}: got {!r}, expected {} finite number{}'.format(
            name, text, count, '' if count == 1 else 's'))
    return values


def read_number(name: str, text: Optional[str]) -> float:
    """Return a finite number; SimulationError naming what it is when it is not that."""
    return float(read_numbers(name, text, 1)[0])


def read_mass(name: str, text: Optional[str]) -> float:
    """Return a finite number as it is, for a message about it; errors as for `read_number`."""
    return float(_finite(name, text, 1)[0])


def read_share(name: str, text: Optional[str]) -> float:
    """Return the nearest number from 0 to 1; SimulationError as for `read_number`.

    >>> read_share('decay of link a', '1.5')
    1.0
    """
    return min(max(read_number(name, text), 0.0), 1.0)


def read_limit(name: str, text: Optional[str]) -> float:
    """Return a number that may be infinite; SimulationError as for `read_number`.

    >>> read_limit('upper of joint a', '+Inf')
    inf
    """
    if _INFINITE.fullmatch((text or '').strip()):
        return float(text or '')
    return read_number(name, text)


def whole(text: str) -> int:
    """Return the whole number that a text begins with, as sdformat reads it; else ValueError.

    >>> whole('360.5'), whole('0x10'), whole('3.6e2')
    (360, 16, 3)
    """
    found = _WHOLE.match(text)
    if found is None:
        raise ValueError(text)
    return int(found.group(1) + found.group(2), 0 if 'x' in found.group(2).lower() else 10)


def read_whole(name: str, text: Optional[str]) -> int:
    """Return a whole number, as `whole` does; SimulationError naming what it is if there is none.
    """
    try:
        return whole(text or '')
    except ValueError:
        raise SimulationError('{}: got {!r}, expected a whole number'.format(name, text))


def read_direction(name: str, text: Optional[str]) -> np.ndarray:
    """Return a vector (3,) of any length; SimulationError naming it when it is 0."""
    values = read_numbers(name, text, 3)
    if not np.any(values):
        raise SimulationError('{}: got 0 0 0, expected a direction'.format(name))
    return values


def read_axis(name: str, text: Optional[str]) -> np.ndarray:
    """Return a direction as a unit vector (3,), as `read_direction` reads it.

    >>> read_axis('axis of joint a', '0 3 4').tolist()
    [0.0, 0.6, 0.8]
    """
    values = read_direction(name, text)
    return values / np.linalg.norm(values)


def read_lengths(name: str, text: Optional[str], count: int) -> np.ndarray:
    """Return `count` lengths in m, or scales; SimulationError when one is too large to be used.

    >>> read_lengths('size of a box', '1 2 0.5', 3).tolist()
    [1.0, 2.0, 0.5]
    """
    values = read_numbers(name, text, count)
    if np.abs(values).max() > _MAX_LENGTH:
        raise SimulationError('{}: got {!r}, expected numbers from {:g} to {:g}'.format(
            name, text, -_MAX_LENGTH, _MAX_LENGTH))
    return values


def read_coefficient(name: str, text: Optional[str]) -> float:
    """Return a coefficient of friction; SimulationError naming it when it is negative.

    >>> read_coefficient('mu1 of link a', '-1')
    Traceback (most recent call last):
    img_recog.errors.SimulationError: mu1 of link a: got -1, expected at least 0
    """
    value = read_number(name, text)
    if value < 0:
        raise SimulationError('{}: got {:g}, expected at least 0'.format(name, value))
    return value


def words(values: Iterable[float]) -> str:
    """Return numbers as the text of an attribute; SimulationError if one is NaN.

    >>> words((1, 0.5))
    '1.0 0.5'
    """
    numbers = [float(value) for value in values]
    if any(map(math.isnan, numbers)):
        raise SimulationError('got the numbers {}, expected none that is nan'.format(numbers))
    return ' '.join(map(repr, numbers))
