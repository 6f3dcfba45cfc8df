"""Frames that OpenCV reads: V4L2 devices, films and still images."""
import glob
import os
from typing import Optional

import cv2
import numpy as np

from img_recog.camera.settings import FOURCC, GREY_FORMATS, CameraSettings
from img_recog.camera.source import FrameSource, SourceError

_NOT_PLAYABLE = ('cannot play {}: neither a film nor an image that OpenCV reads; set video_device '
                 'to one, or to synthetic')


def list_devices() -> str:
    """Return the V4L2 devices of this machine as words for an error line."""
    return ', '.join(sorted(glob.glob('/dev/video*'))) or 'no /dev/video*'


class DeviceSource(FrameSource):
    """A V4L2 device; `read` waits for its next frame."""

    def __init__(self, settings: CameraSettings):
        self._path = settings.video_device
        self._check_access()
        self._capture = cv2.VideoCapture(os.path.realpath(self._path), cv2.CAP_V4L2)
        if not self._capture.isOpened():
            raise SourceError(
                'cannot open {}: no V4L2 capture device, or in use by another program (have {}); '
                'set video_device to one of these, a file, or synthetic'
                .format(self._path, list_devices()))
        self._negotiate(settings)

    def _check_access(self) -> None:
        # OpenCV says only "can't open"; open(2) knows why
        try:
            os.close(os.open(self._path, os.O_RDWR | os.O_NONBLOCK))
        except PermissionError as error:
            raise SourceError('cannot open {}: {}; add yourself to the group video, or run as a '
                              'user who may read it'.format(self._path, error.strerror))
        except OSError as error:
            raise SourceError('cannot open {}: {} (have {}); set video_device to one of these, a '
                              'file, or synthetic'
                              .format(self._path, error.strerror, list_devices()))

    def _negotiate(self, settings: CameraSettings) -> None:
        # the format first: the sizes and rates that a camera offers hang on it
        wanted = FOURCC[settings.pixel_format]
        self._capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*wanted))
        self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, settings.image_width)
        self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, settings.image_height)
        self._capture.set(cv2.CAP_PROP_FPS, settings.framerate)
        self.encoding = 'mono8' if settings.pixel_format in GREY_FORMATS else 'rgb8'
        self.width = int(self._capture.get(cv2.CAP_PROP_FRAME_WIDTH))
        self.height = int(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
        number = int(self._capture.get(cv2.CAP_PROP_FOURCC))
        given = ''.join(chr(number >> shift & 0xff) for shift in (0, 8, 16, 24))
        self.description = (
            'V4L2 device {}: asked for {} {}x{} at {:g} Hz, got {} {}x{} at {:g} Hz'.format(
                self._path, wanted.strip(), settings.image_width, settings.image_height,
                settings.framerate, given.strip(), self.width, self.height,
                self._capture.get(cv2.CAP_PROP_FPS)))

    def read(self) -> np.ndarray:
        good, image = self._capture.read()
        if not good or image is None:
            raise SourceError('{} gives no more frames: unplugged or silent; plug it in and '
                              'start the node again'.format(self._path))
        return _converted(image, self.encoding)

    def close(self) -> None:
        self._capture.release()


class FilmSource(FrameSource):
    """A film that plays at its own rate and starts again at its end."""

    def __init__(self, path: str):
        self._path = path
        self._capture = cv2.VideoCapture(path, cv2.CAP_FFMPEG)
        self.rate_hz = self._capture.get(cv2.CAP_PROP_FPS)
        good, self._next = self._capture.read()
        if not good:
            raise SourceError(_NOT_PLAYABLE.format(path))
        if not self.rate_hz > 0:
            raise SourceError('cannot play {}: it does not say its frame rate'.format(path))
        self.height, self.width = self._next.shape[:2]
        self.description = 'film {}, {}x{}, {:g} Hz, played in a loop'.format(
            path, self.width, self.height, self.rate_hz)

    def read(self) -> np.ndarray:
        frame = self._next
        good, self._next = self._capture.read()
        if not good:
            # opened anew rather than wound back: seeking is inexact in many containers
            self._capture.release()
            self._capture = cv2.VideoCapture(self._path, cv2.CAP_FFMPEG)
            good, self._next = self._capture.read()
            if not good or self._next.shape[:2] != (self.height, self.width):
                raise SourceError('{} can no longer be read: moved or replaced while it played'
                                  .format(self._path))
        return _converted(frame, self.encoding)

    def close(self) -> None:
        self._capture.release()


class StillSource(FrameSource):
    """A still image, repeated."""

    def __init__(self, path: str, image: np.ndarray, rate_hz: float):
        self._image = _converted(image, self.encoding)
        self.height, self.width = image.shape[:2]
        self.rate_hz = rate_hz
        self.description = 'still image {}, {}x{}, {:g} Hz'.format(
            path, self.width, self.height, rate_hz)

    def read(self) -> np.ndarray:
        return self._image.copy()


def open_file(path: str, rate_hz: float) -> FrameSource:
    """Open a still image (repeated at `rate_hz`) or a film (at its own rate).

    Raises SourceError when OpenCV reads the file as neither.
    """
    if not os.access(path, os.R_OK):
        raise SourceError('cannot read {}: permission denied'.format(path))
    image = _read_image(path)
    if image is not None:
        return StillSource(path, image, rate_hz)
    if _is_text(path):
        raise SourceError(_NOT_PLAYABLE.format(path))
    return FilmSource(path)


def _read_image(path: str) -> Optional[np.ndarray]:
    try:
        return cv2.imread(path, cv2.IMREAD_COLOR) if cv2.haveImageReader(path) else None
    except cv2.error:       # its header claims more pixels than OpenCV allows
        return None


def _is_text(path: str) -> bool:
    # ffmpeg plays a text file as a film of its letters
    with open(path, 'rb') as file:
        start = file.read(4096)
    return bool(start) and all(byte >= 32 or byte in b'\t\n\f\r\x1b' for byte in start)


def _converted(image: np.ndarray, encoding: str) -> np.ndarray:
    """Return OpenCV's bgr8 or grey `image` in the encoding that is published."""
    if encoding == 'mono8':
        return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return cv2.cvtColor(image, cv2.COLOR_GRAY2RGB if image.ndim == 2 else cv2.COLOR_BGR2RGB)
