"""What a number of runs says about a rate."""
import math
from typing import Tuple

_Z = 1.959964       # of 95 %, two-sided


def wilson(successes: int, runs: int) -> Tuple[float, float]:
    """Return the 95 % confidence interval of a rate of success (Wilson 1927).

    >>> [round(end, 3) for end in wilson(9, 10)]
    [0.596, 0.982]
    >>> wilson(0, 0)
    (0.0, 1.0)
    """
    if not runs:
        return 0.0, 1.0
    rate, square = successes / runs, _Z ** 2 / runs
    middle = rate + square / 2
    margin = _Z * math.sqrt(rate * (1 - rate) / runs + square / (4 * runs))
    return (max(0.0, (middle - margin) / (1 + square)), min(1.0, (middle + margin) / (1 + square)))
