"""The thread of the capture: start, stop, a source that blocks, and file descriptors."""
import os
import threading

import numpy as np
import pytest

from img_recog.camera.capture import Capture, Listener
from img_recog.camera.source import FrameSource
from img_recog_helpers.descriptors import times_open
from img_recog_helpers.waiting import DEADLINE_S, wait_for

IMAGE = np.zeros((2, 2, 3), np.uint8)


class Blocking(threading.Event):
    """Set while the source has to block; `reached` is set when it does."""

    def __init__(self):
        super().__init__()
        self.reached = threading.Event()

    def begin(self):
        """Block the source; return when it is blocked."""
        self.set()
        assert self.reached.wait(DEADLINE_S)


class RealFile(FrameSource):
    """Holds a file descriptor and gives a frame each millisecond, unless the event is set."""

    width = height = 2
    name = description = 'real'
    reconnects, stall_timeout_s = True, 0.05

    def __init__(self, blocking, path):
        self._blocking, self._descriptor = blocking, os.open(path, os.O_RDONLY)

    def read(self):
        while self._blocking.is_set():
            self._blocking.reached.set()
            threading.Event().wait(0.001)
        threading.Event().wait(0.001)
        return IMAGE

    def close(self):
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            os.close(descriptor)


class Counter(Listener):
    def __init__(self):
        self.frames = self.losses = self.reconnections = 0

    def frame(self, source, image):
        self.frames += 1

    def lost(self, reason):
        self.losses += 1

    def reconnected(self):
        self.reconnections += 1


@pytest.fixture
def device(tmp_path):
    path = tmp_path / 'device'
    path.touch()
    return str(path)


@pytest.fixture
def running(monkeypatch, device):
    """A capture in its thread, its listener, and the event that blocks its source."""
    for name in ('_STOP_TIMEOUT_S', '_JOIN_TIMEOUT_S'):     # a busy machine may need longer
        monkeypatch.setattr('img_recog.camera.capture.' + name, DEADLINE_S)
    blocking, listener = Blocking(), Counter()
    capture = Capture(lambda: RealFile(blocking, device), listener)
    capture.start_thread()
    yield capture, listener, blocking
    blocking.clear()
    capture.shut_down()


def test_twenty_rounds_of_start_and_stop_leave_no_descriptor(running, device):
    capture, listener, _ = running
    for _ in range(20):
        count = listener.frames
        capture.start()
        capture.start()
        wait_for(lambda: listener.frames > count, 'a frame')
        assert times_open(device) == 1
        assert capture.stop() and capture.stop()
        assert times_open(device) == 0
    assert capture.shut_down()


def test_stop_before_start_returns_immediately(running):
    capture, listener, _ = running
    assert capture.stop()
    assert not capture.wanted and listener.frames == 0


def test_blocked_source_is_reported_and_continues(running):
    capture, listener, blocking = running
    capture.start()
    wait_for(lambda: listener.frames > 0, 'a frame')
    blocking.begin()
    wait_for(lambda: capture.check() or listener.losses, 'the loss')
    blocking.clear()
    wait_for(lambda: listener.reconnections, 'the reconnection')
    assert (listener.losses, listener.reconnections) == (1, 1)


def test_owner_does_not_wait_for_a_source_that_blocks(running, monkeypatch):
    monkeypatch.setattr('img_recog.camera.capture._STOP_TIMEOUT_S', 0.05)
    monkeypatch.setattr('img_recog.camera.capture._JOIN_TIMEOUT_S', 0.05)
    capture, listener, blocking = running
    capture.start()
    wait_for(lambda: listener.frames > 0, 'a frame')
    blocking.begin()
    wait_for(lambda: capture.check() or listener.losses, 'the loss')
    assert not capture.stop()
    assert not capture.shut_down()
    blocking.clear()
    wait_for(capture.shut_down, 'the end of the thread')


def test_start_after_shut_down_does_nothing(running):
    capture, listener, _ = running
    assert capture.shut_down()
    capture.start()
    assert listener.frames == 0
    assert 'capture' not in [thread.name for thread in threading.enumerate()]
