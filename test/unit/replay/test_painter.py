"""The process that draws the picture: its result, and what happens when it ends early."""
import gc
import os
import signal

import cv2
import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.settings import with_colors
from img_recog.replay import painter as painter_module
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


class FakeConnection:
    """The end of the pipe in the process: gives what is to be drawn, or fails."""

    def __init__(self, received=None, refuses=False):
        self._received, self._refuses = received, refuses
        self.sent, self.closed = [], 0

    def recv(self):
        if self._received is None:
            raise EOFError
        return self._received

    def send_bytes(self, data):
        if self._refuses:
            raise BrokenPipeError
        self.sent.append(bytes(data[:4]))

    def close(self):
        self.closed += 1


@pytest.mark.parametrize('received, refuses, sent', [
    (('a test', DATA), False, [b'\x89PNG']), (('a test', DATA), True, []), (None, False, [])])
def test_the_process_draws_once_and_ends_quietly_when_nobody_waits(monkeypatch, received,
                                                                   refuses, sent):
    ignored, disabled = [], []
    monkeypatch.setattr(signal, 'signal', lambda *args: ignored.append(args))
    monkeypatch.setattr(gc, 'disable', lambda: disabled.append(True))
    parent, connection = FakeConnection(), FakeConnection(received, refuses)
    painter_module._serve(parent, connection)
    assert connection.sent == sent and parent.closed == 1 and connection.closed == 0
    assert ignored == [(signal.SIGINT, signal.SIG_IGN), (signal.SIGHUP, signal.SIG_IGN)]
    assert disabled == [True]


def test_the_process_is_a_daemon_and_the_other_end_is_its_own():
    with Painter() as painter:
        assert painter._process.daemon
        os.kill(painter.pid, signal.SIGKILL)
        painter._process.join()
        # without another open end, the end of the process is the end of the pipe
        with pytest.raises(UserError, match='check whether it was killed because memory ran out'):
            painter.finish()
    assert painter._connection.closed
