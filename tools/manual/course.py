"""The lane of AutoRace 2020: where its lines are, and how the robot follows it."""
import math
from typing import List, Tuple

import cv2
import numpy as np

# of the model: the texture covers this square in m, turned by 180 degrees
_SIDE_M, _SIDE_PX = 4.0, 800
_BRIGHT, _DARK = 150, 80


class Course:
    """The yellow line on the left of the lane and the white one on its right."""

    def __init__(self, picture: np.ndarray):
        """picture: the texture of the floor, bgr8."""
        blue, green, red = cv2.split(cv2.resize(picture, (_SIDE_PX, _SIDE_PX),
                                                interpolation=cv2.INTER_NEAREST))
        colored = (green > _BRIGHT) & (red > _BRIGHT)
        self._yellow, self._white = (
            cv2.distanceTransform((~line).astype(np.uint8), cv2.DIST_L2, 5) * _SIDE_M / _SIDE_PX
            for line in (colored & (blue < _DARK), colored & (blue > _BRIGHT)))

    def lines(self, x: float, y: float) -> Tuple[float, float]:
        """Return the distances in m from the nearest yellow and the nearest white line.

        x, y: in the world, m.
        """
        column, row = (int((_SIDE_M / 2 + value) / _SIDE_M * _SIDE_PX) for value in (-x, y))
        if not (0 <= column < _SIDE_PX and 0 <= row < _SIDE_PX):
            return math.inf, math.inf
        return float(self._yellow[row, column]), float(self._white[row, column])


class LaneDrive:
    """A drive along the lane.

    corners: turns by a right angle, to either side. off_middle: the distances from the middle of
    the lane, m. is_inside: whether the robot was between the lines of a lane all the time.
    """

    _CORNER_RAD = math.radians(80)
    _WIDEST_M = 0.5         # the distances from both lines of a lane are together less

    def __init__(self, course: Course):
        self._course = course
        self._last: Tuple[float, ...] = ()
        self._turned_rad, self.corners, self.driven_m = 0.0, 0, 0.0
        self.off_middle: List[float] = []
        self.is_inside = True

    def add(self, x: float, y: float, yaw: float) -> None:
        """Take the next true pose, m and rad."""
        if self._last:
            self.driven_m += math.dist((x, y), self._last[:2])
            self._turned_rad += math.remainder(yaw - self._last[2], 2 * math.pi)
        self._last = x, y, yaw
        if abs(self._turned_rad) > self._CORNER_RAD:
            self.corners += 1
            self._turned_rad -= math.copysign(math.pi / 2, self._turned_rad)
        yellow, white = self._course.lines(x, y)
        if yellow + white < self._WIDEST_M:
            self.off_middle.append(abs(white - yellow) / 2)
        else:
            self.is_inside = False
