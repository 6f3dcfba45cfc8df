"""The numbers that the picture of a replay is drawn from."""
from typing import NamedTuple, Sequence

import numpy as np

from img_recog.recognition.settings import Color

# the columns of `rows`; areas follow
TIME, X, Y, YAW, SPEED, TURN, AREAS = range(7)


class PlotData(NamedTuple):
    """What happened.

    rows: (frames, columns), at each frame; recognition, teleop: (commands, 3), what each of them
    sent: time in s, linear.x in m/s, angular.z in rad/s; end_s: when the last frame is over;
    outlines: (corners, 2) in m, of what is in the world.
    """

    colors: Sequence[Color]
    rows: np.ndarray
    recognition: np.ndarray
    teleop: np.ndarray
    end_s: float
    outlines: Sequence[np.ndarray]
