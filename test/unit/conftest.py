"""Fixtures for several unit tests."""
import signal
import sys

import cv2
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog_helpers.videos import VIDEO_RATE_HZ, smooth_image
from img_recog_helpers.waiting import DEADLINE_S


_MAX_PHYSICS_CLIENTS = 128      # PyBullet takes the first one that is free


class FakeClock:
    """A clock that moves only in `advance`."""

    def __init__(self):
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def advance(self, seconds: float) -> None:
        """Move the clock forward by `seconds`."""
        self.now_s += seconds


@pytest.fixture(autouse=True)
def handlers_as_before():
    """Set the handlers of signals that end a program as they were, after the test.

    A program that a test runs in its own process would leave them to the tests after it.
    """
    before = {signum: signal.getsignal(signum)
              for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for signum, handler in before.items():
        signal.signal(signum, handler)


@pytest.fixture(autouse=True)
def _end_physics_clients():
    """End the physics clients that a test has started: PyBullet has room for 1024."""
    before = _physics_clients()
    yield
    for client in _physics_clients() - before:
        sys.modules['pybullet'].disconnect(physicsClientId=client)


def _physics_clients():
    pybullet = sys.modules.get('pybullet')      # most tests do not need it
    return {client for client in range(_MAX_PHYSICS_CLIENTS)
            if pybullet and pybullet.isConnected(physicsClientId=client)}


@pytest.fixture
def patient_helper(monkeypatch):
    """A busy machine may need longer for the exit of a helper process."""
    monkeypatch.setattr('img_recog.processes.helper_process._EXIT_TIMEOUT_S', DEADLINE_S)


@pytest.fixture
def impatient(monkeypatch):
    """A helper process that does not end is killed at once."""
    monkeypatch.setattr('img_recog.processes.helper_process._EXIT_TIMEOUT_S', 0.2)


@pytest.fixture
def clock():
    """A FakeClock."""
    return FakeClock()


@pytest.fixture
def make_video(tmp_path):
    """A function that writes a video of smooth images, 12.5 Hz, and returns its path."""
    def make(name='video.avi', fourcc='MJPG', frames=6, size=(96, 64)):
        path = str(tmp_path / name)
        writer = cv2.VideoWriter(path, cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*fourcc),
                                 VIDEO_RATE_HZ, size)
        if not writer.isOpened():
            pytest.skip('this OpenCV cannot write {}'.format(fourcc))
        for number in range(frames):
            writer.write(smooth_image(number, *size))
        writer.release()
        return path
    return make


@pytest.fixture
def status():
    """A status of /diagnostics at level OK, with the message 'fine'."""
    made = DiagnosticStatusWrapper()
    made.summary(DiagnosticStatus.OK, 'fine')
    return made
