"""The process that draws: a picture, a process that ends, and one that is left."""
import os
import signal

import cv2
import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.settings import with_colors
from img_recog.replay.painter import Painter
from img_recog.replay.plot_data import PlotData

NUMBERS = PlotData(with_colors()().colors, np.ones((3, 8)), np.ones((2, 3)), np.zeros((0, 3)), 1.0,
                   [])


def test_it_draws():
    with Painter() as painter:
        painter.begin('a test', NUMBERS)
        image = cv2.imdecode(np.frombuffer(painter.finish(), np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (900, 1400, 3)


def test_one_that_is_killed_is_named():
    with Painter() as painter:
        os.kill(painter.number, signal.SIGKILL)
        painter.begin('a test', NUMBERS)
        with pytest.raises(UserError, match='cannot be drawn: .* exit code -9'):
            painter.finish()


def test_left_early_it_is_gone():
    with Painter() as painter:
        assert os.path.exists('/proc/{}'.format(painter.number))
    assert not os.path.exists('/proc/{}'.format(painter.number))
