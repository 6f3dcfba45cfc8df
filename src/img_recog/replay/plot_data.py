"""The data from which the picture of a drive is drawn."""
from typing import NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from img_recog.recognition.recognition_settings import Color

TIME, X, Y, YAW, SPEED, TURN = range(6)         # columns of `motion`


class PlotColor(NamedTuple):
    """A color of which only this is known. area_limit_px: None if not known."""

    name: str
    hue: Tuple[int, int]
    area_limit_px: Optional[int] = None


class PlotData(NamedTuple):
    """The data of a replay, or of a drive that was recorded.

    motion: shape (states, 6), at least one state of the robot; the columns are named above.
    areas: shape (images, 1 + colors), time in s and area of each color in pixels.
    commands, idle: shape (commands, 3), time in s, linear.x in m/s, angular.z in rad/s; idle: of
    senders that say nothing else than zero.
    end_s: time of the end. outlines: shape (corners, 2) in m, of the objects in the world.
    moved: numbers of the states to which the robot was put, rather than driven.
    """

    colors: Sequence[Union[Color, PlotColor]]
    motion: np.ndarray
    areas: np.ndarray
    commands: np.ndarray
    idle: np.ndarray
    end_s: float
    outlines: Sequence[np.ndarray]
    moved: Sequence[int] = ()
