"""V4L2 devices with a fake of OpenCV's capture: the requested format, and the frames."""
import os

import cv2
import numpy as np
import pytest

from img_recog.camera.device_source import DeviceSource
from img_recog.camera.source import FrameSkipped, SourceError
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog_helpers.refusals import refusal

DAMAGED = object()
BGR = np.random.RandomState(3).randint(0, 256, (48, 64, 3)).astype(np.uint8)


class FakeCapture:
    """A camera of 64x48 at 15 Hz that gives `frames`."""

    frames = [BGR]
    captured_s = -1.0

    def __init__(self, path, backend):
        self.opened, self.requested, self.released = (path, backend), [], 0
        self.given = {cv2.CAP_PROP_FRAME_WIDTH: 64.0, cv2.CAP_PROP_FRAME_HEIGHT: 48.0,
                      cv2.CAP_PROP_FPS: 15.0, cv2.CAP_PROP_POS_MSEC: self.captured_s * 1000.0,
                      cv2.CAP_PROP_FOURCC: float(cv2.VideoWriter_fourcc(*'YUYV'))}
        self._frames = iter(self.frames)

    def isOpened(self):
        return True

    def set(self, prop, value):
        self.requested.append((prop, value))
        return True

    def get(self, prop):
        return self.given[prop]

    def grab(self):
        self._image = next(self._frames, None)
        return self._image is not None

    def retrieve(self):
        return self._image is not DAMAGED, None if self._image is DAMAGED else self._image

    def release(self):
        self.released += 1


@pytest.fixture
def open_device(monkeypatch):
    """A function that opens a device with a FakeCapture; returns both."""
    def open_with(video_device='/dev/null', **settings):
        captures = []
        monkeypatch.setattr(cv2, 'VideoCapture',
                            lambda *arguments: captures.append(FakeCapture(*arguments))
                            or captures[-1])
        source = DeviceSource(UsbCamSettings(video_device=video_device, **settings),
                              now=lambda: 100.0)
        return source, captures[0]
    return open_with


def test_format_is_requested_before_size_and_rate(open_device):
    _, capture = open_device(pixel_format='mjpeg', image_width=320, image_height=240,
                             framerate=10)
    assert capture.opened == ('/dev/null', cv2.CAP_V4L2)
    assert os.environ['OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT'] == '2'       # seconds
    assert capture.requested == [
        (cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*'MJPG')),
        (cv2.CAP_PROP_FRAME_WIDTH, 320), (cv2.CAP_PROP_FRAME_HEIGHT, 240),
        (cv2.CAP_PROP_FPS, 10.0)]


@pytest.mark.parametrize('pixel_format, fourcc, encoding', [
    ('mjpeg', 'MJPG', 'rgb8'), ('yuyv', 'YUYV', 'rgb8'), ('uyvy', 'UYVY', 'rgb8'),
    ('rgb24', 'RGB3', 'rgb8'), ('bgr24', 'BGR3', 'rgb8'), ('yu12', 'YU12', 'rgb8'),
    ('h264', 'MJPG', 'rgb8'), ('grey', 'GREY', 'mono8'), ('yuvmono10', 'Y10 ', 'mono8')])
def test_fourcc_and_encoding_of_each_format(open_device, pixel_format, fourcc, encoding):
    source, capture = open_device(pixel_format=pixel_format)
    assert capture.requested[0] == (cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*fourcc))
    assert source.encoding == encoding
    assert source.differs       # the device gives YUYV
    wanted = BGR[..., ::-1] if encoding == 'rgb8' else cv2.cvtColor(BGR, cv2.COLOR_BGR2GRAY)
    assert np.array_equal(source.read(), wanted)


def test_grey_frames_are_passed_on(open_device, monkeypatch):
    monkeypatch.setattr(FakeCapture, 'frames', [BGR[..., 1].copy()])
    source, _ = open_device(pixel_format='grey')
    assert np.array_equal(source.read(), BGR[..., 1])


@pytest.mark.parametrize('differs, settings', [
    (False, ('yuyv', 64, 48)), (True, ('mjpeg', 64, 48)), (True, ('yuyv', 60, 48)),
    (True, ('yuyv', 64, 50))])
def test_size_is_that_of_the_device_and_another_one_than_requested_is_flagged(
        open_device, differs, settings):
    pixel_format, width, height = settings
    source, _ = open_device(pixel_format=pixel_format, image_width=width, image_height=height)
    assert (source.width, source.height, source.rate_hz) == (64, 48, None)
    assert source.differs is differs
    fourcc = {'yuyv': 'YUYV', 'mjpeg': 'MJPG'}[pixel_format]
    assert source.description == (
        'V4L2 device /dev/null: asked for {} {}x{} at 30 Hz, got YUYV 64x48 at 15 Hz'.format(
            fourcc, width, height))


def test_unplugged_device_is_a_one_line_error(open_device):
    source, capture = open_device()
    source.read()
    with pytest.raises(SourceError, match='^/dev/null gives no frames: unplugged or silent$'):
        source.read()
    assert source.reconnects
    source.close()
    assert capture.released == 1


@pytest.mark.parametrize('error, words', [
    (PermissionError(13, 'Permission denied'), 'Permission denied; add your user to the '),
    (OSError(16, 'Device or resource busy'), 'Device or resource busy (there ')])
def test_device_that_cannot_be_opened_gives_the_reason(open_device, monkeypatch, error, words):
    def refuse(*_):
        raise error
    monkeypatch.setattr('img_recog.camera.device_source.os.open', refuse)
    assert refusal(open_device).startswith('cannot open /dev/null: ' + words)


@pytest.mark.parametrize('captured_s, age_s', [
    (99.96, 0.04), (100.0, 0.0), (98.5, 1.5),
    (97.0, 0.0), (100.5, 0.0), (1.7e9, 0.0), (0.0, 0.0), (-1.0, 0.0)])
def test_age_is_that_of_the_driver_if_it_is_valid(open_device, monkeypatch, captured_s, age_s):
    monkeypatch.setattr(FakeCapture, 'captured_s', captured_s)
    source, _ = open_device()
    source.read()
    assert source.age_s == pytest.approx(age_s, abs=1e-9)


@pytest.mark.parametrize('frame, problem', [
    (DAMAGED, 'gave an empty or damaged frame$'),
    (np.empty((0, 0, 3), np.uint8), 'gave an empty or damaged frame$'),
    (BGR[:40], r'gave a frame of shape \(40, 64, 3\) instead of 64x48$')])
def test_frame_that_is_unusable_is_skipped_and_the_next_one_read(
        open_device, monkeypatch, frame, problem):
    monkeypatch.setattr(FakeCapture, 'frames', [frame, BGR.reshape(1, -1)])
    source, _ = open_device()
    with pytest.raises(FrameSkipped, match='^/dev/null ' + problem):
        source.read()
    assert np.array_equal(source.read(), BGR[..., ::-1])        # one in a single row is reshaped


@pytest.mark.parametrize('framerate, expected_hz, stall_timeout_s', [
    (10, 10.0, 1.5), (0.5, 0.5, 6.0), (30, 15.0, 1.5)])
def test_rates_and_timeout_follow_the_requested_and_the_actual_rate(
        open_device, framerate, expected_hz, stall_timeout_s):
    source, _ = open_device(framerate=framerate)
    assert (source.max_hz, source.expected_hz, source.stall_timeout_s) == (
        framerate, expected_hz, stall_timeout_s)


def test_path_is_the_target_of_a_symlink(open_device, tmp_path):
    link = tmp_path / 'by-id'
    link.symlink_to('/dev/null')
    source, capture = open_device(str(link))
    assert (source.name, source.path) == (str(link), '/dev/null')
    assert capture.opened == ('/dev/null', cv2.CAP_V4L2)


def test_clock_of_a_driver_that_was_wrong_once_is_ignored(open_device, monkeypatch):
    monkeypatch.setattr(FakeCapture, 'frames', [BGR] * 3)
    source, capture = open_device()
    ages = []
    for captured_s in (99.5, 100.5, 99.5):
        capture.given[cv2.CAP_PROP_POS_MSEC] = captured_s * 1000.0
        source.read()
        ages.append(source.age_s)
    assert ages == pytest.approx([0.5, 0.0, 0.0])


def test_access_is_checked_for_reading_and_writing_without_waiting(open_device, monkeypatch):
    opened, close = [], []
    monkeypatch.setattr('img_recog.camera.device_source.os.open',
                        lambda *args: opened.append(args) or 77)
    monkeypatch.setattr('img_recog.camera.device_source.os.close', close.append)
    open_device()
    assert opened == [('/dev/null', os.O_RDWR | os.O_NONBLOCK)] and close == [77]
