"""Follows the wall on the right, by a laser scan, until the robot is where it has begun."""
import math
from typing import Sequence, Tuple

import numpy as np

_SPEED, _TURN = 0.18, 0.9           # m/s, rad/s
_WALL_M, _AHEAD_M = 0.45, 0.50      # kept to the wall, and before the robot turns to the left
_GAIN = 2.0                         # rad/s for each m
_ROUND_M, _NEAR_M = 6.0, 0.5


def command(ranges: Sequence[float], angle_min: float, angle_increment: float
            ) -> Tuple[float, float]:
    """Return the velocity in m/s and the angular velocity in rad/s for a scan.

    ranges: m; inf, nan and 0 are nothing in sight.
    """
    distances = np.array(ranges, float)
    distances[~np.isfinite(distances) | (distances <= 0)] = math.inf
    angles = angle_min + np.arange(len(distances)) * angle_increment
    angles = (angles + math.pi) % (2 * math.pi) - math.pi

    def nearest(begin: float, end: float) -> float:
        inside = distances[(angles >= math.radians(begin)) & (angles <= math.radians(end))]
        return float(min(inside, default=math.inf))

    if nearest(-25, 25) < _AHEAD_M:
        return 0.0, _TURN
    right = min(nearest(-120, -25), 2 * _WALL_M)
    return _SPEED, float(np.clip(_GAIN * (_WALL_M - right), -_TURN, _TURN))


class Round:
    """Whether the robot has gone round and is back."""

    def __init__(self, start: Tuple[float, float]):
        self._start = self._last = start
        self.driven_m = 0.0

    def is_complete(self, position: Tuple[float, float]) -> bool:
        """Take the next position, in m; return whether the robot is back at its start."""
        self.driven_m += math.dist(position, self._last)
        self._last = position
        return self.driven_m > _ROUND_M and math.dist(position, self._start) < _NEAR_M
