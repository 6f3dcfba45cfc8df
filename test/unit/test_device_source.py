"""V4L2 devices, with OpenCV's capture replaced: what is asked for and what is made of it."""
import cv2
import numpy as np
import pytest

from img_recog.camera.opencv_source import DeviceSource
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import SourceError

BGR = np.random.RandomState(3).randint(0, 256, (48, 64, 3)).astype(np.uint8)


class FakeCapture:
    """Grants a camera of 64x48 at 15 Hz and gives the frames it is told."""

    frames = [BGR]

    def __init__(self, path, backend):
        self.opened, self.asked, self.released = (path, backend), [], 0
        self._given = {cv2.CAP_PROP_FRAME_WIDTH: 64.0, cv2.CAP_PROP_FRAME_HEIGHT: 48.0,
                       cv2.CAP_PROP_FPS: 15.0,
                       cv2.CAP_PROP_FOURCC: float(cv2.VideoWriter_fourcc(*'YUYV'))}
        self._frames = iter(self.frames)

    def isOpened(self):
        return True

    def set(self, prop, value):
        self.asked.append((prop, value))
        return True

    def get(self, prop):
        return self._given[prop]

    def read(self):
        image = next(self._frames, None)
        return image is not None, image

    def release(self):
        self.released += 1


@pytest.fixture
def open_device(monkeypatch):
    """A function that opens a device with a FakeCapture; returns both."""
    def open_with(**settings):
        captures = []
        monkeypatch.setattr(cv2, 'VideoCapture',
                            lambda *arguments: captures.append(FakeCapture(*arguments))
                            or captures[-1])
        source = DeviceSource(CameraSettings(video_device='/dev/null', **settings))
        return source, captures[0]
    return open_with


def test_format_is_asked_for_before_size_and_rate(open_device):
    _, capture = open_device(pixel_format='mjpeg', image_width=320, image_height=240,
                             framerate=10)
    assert capture.opened == ('/dev/null', cv2.CAP_V4L2)
    assert capture.asked == [
        (cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*'MJPG')),
        (cv2.CAP_PROP_FRAME_WIDTH, 320), (cv2.CAP_PROP_FRAME_HEIGHT, 240),
        (cv2.CAP_PROP_FPS, 10.0)]


@pytest.mark.parametrize('pixel_format, fourcc', [
    ('mjpeg', 'MJPG'), ('yuyv', 'YUYV'), ('uyvy', 'UYVY'), ('rgb24', 'RGB3'), ('grey', 'GREY'),
    ('yuvmono10', 'Y10 ')])
def test_fourcc_of_each_format(open_device, pixel_format, fourcc):
    _, capture = open_device(pixel_format=pixel_format)
    assert capture.asked[0] == (cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*fourcc))


def test_size_is_what_the_device_gives_and_read_waits_for_it(open_device):
    source, _ = open_device(image_width=320, image_height=240)
    assert (source.width, source.height, source.rate_hz) == (64, 48, None)
    assert source.description == ('V4L2 device /dev/null: asked for MJPG 320x240 at 30 Hz, '
                                  'got YUYV 64x48 at 15 Hz')


@pytest.mark.parametrize('pixel_format', ['mjpeg', 'yuyv', 'uyvy', 'rgb24'])
def test_colour_formats_give_rgb8(open_device, pixel_format):
    source, _ = open_device(pixel_format=pixel_format)
    assert source.encoding == 'rgb8'
    assert np.array_equal(source.read(), BGR[..., ::-1])


@pytest.mark.parametrize('pixel_format', ['grey', 'yuvmono10'])
@pytest.mark.parametrize('given', [BGR, BGR[..., 1].copy()])
def test_grey_formats_give_mono8(open_device, monkeypatch, pixel_format, given):
    monkeypatch.setattr(FakeCapture, 'frames', [given])
    source, _ = open_device(pixel_format=pixel_format)
    assert source.encoding == 'mono8'
    wanted = given if given.ndim == 2 else cv2.cvtColor(given, cv2.COLOR_BGR2GRAY)
    assert np.array_equal(source.read(), wanted)


def test_unplugged_device_is_an_error_of_one_line(open_device):
    source, _ = open_device()
    source.read()
    with pytest.raises(SourceError) as refused:
        source.read()
    assert str(refused.value) == ('/dev/null gives no more frames: unplugged or silent; plug it '
                                  'in and start the node again')


def test_close_releases_the_device(open_device):
    source, capture = open_device()
    source.close()
    assert capture.released == 1


@pytest.mark.parametrize('error, words', [
    (PermissionError(13, 'Permission denied'), 'Permission denied; add yourself to the group '),
    (OSError(16, 'Device or resource busy'), 'Device or resource busy (have ')])
def test_device_that_cannot_be_opened_says_why(open_device, monkeypatch, error, words):
    def refuse(*_):
        raise error
    monkeypatch.setattr('img_recog.camera.opencv_source.os.open', refuse)
    with pytest.raises(SourceError) as refused:
        open_device()
    assert str(refused.value).startswith('cannot open /dev/null: ' + words)
    assert '\n' not in str(refused.value)
