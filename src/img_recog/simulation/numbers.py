"""Reads the numbers of an XML element."""
import math
from typing import Optional

import numpy as np

from img_recog.simulation.settings import SimulationError


def read_numbers(name: str, text: Optional[str], count: int) -> np.ndarray:
    """Return `count` finite numbers; SimulationError naming what they are when it is not that."""
    try:
        values = np.array([float(word) for word in (text or '').split()])
    except ValueError:
        values = np.array([])
    if len(values) != count or not all(math.isfinite(value) for value in values):
        raise SimulationError('{}: got {!r}, expected {} finite number{}'.format(
            name, text, count, '' if count == 1 else 's'))
    return values
