"""The data from which the picture of a replay is drawn."""
from typing import NamedTuple, Sequence

import numpy as np

from img_recog.recognition.settings import Color

# columns of `rows`; from AREAS on there is one column for each color
TIME, X, Y, YAW, SPEED, TURN, AREAS = range(7)


class PlotData(NamedTuple):
    """The data of a whole replay.

    rows: shape (frames, columns), the state at each frame.
    recognition, teleop: shape (commands, 3), the commands of each sender: time in s, linear.x in
    m/s, angular.z in rad/s.
    end_s: simulated time at the end of the last frame.
    outlines: shape (corners, 2) in m, of the objects in the world.
    """

    colors: Sequence[Color]
    rows: np.ndarray
    recognition: np.ndarray
    teleop: np.ndarray
    end_s: float
    outlines: Sequence[np.ndarray]
