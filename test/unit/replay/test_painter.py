"""The process that draws the picture: its result, and what happens when it ends early."""
import os
import signal

import cv2
import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.settings import with_colors
from img_recog.replay.painter import Painter
from img_recog.replay.plot_data import PlotData

DATA = PlotData(with_colors()().colors, np.ones((3, 8)), np.ones((2, 3)), np.zeros((0, 3)), 1.0,
                [])


def test_it_draws_a_picture():
    with Painter() as painter:
        painter.begin('a test', DATA)
        image = cv2.imdecode(np.frombuffer(painter.finish(), np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (900, 1400, 3)


def test_a_killed_process_is_reported():
    with Painter() as painter:
        os.kill(painter.pid, signal.SIGKILL)
        painter.begin('a test', DATA)
        with pytest.raises(UserError, match='cannot be drawn: .* exit code -9'):
            painter.finish()


def test_it_is_killed_at_the_end_of_the_with():
    with Painter() as painter:
        assert os.path.exists('/proc/{}'.format(painter.pid))
    assert not os.path.exists('/proc/{}'.format(painter.pid))
