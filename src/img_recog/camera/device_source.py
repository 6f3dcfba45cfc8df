"""Frames of a V4L2 device, by OpenCV."""
import glob
import os
import time
from typing import Callable

import cv2
import numpy as np

from img_recog.camera.pixels import converted
from img_recog.camera.settings import FOURCC, GREY_FORMATS, CameraSettings
from img_recog.camera.source import FrameSkipped, FrameSource, SourceError

# A frame is late after this, and after three periods of a slow camera.
_SILENCE_S = 1.5
# Older than this no frame can be: OpenCV holds four of them, and the clock is another one.
_MOST_AGE_S = 2.0


def list_devices() -> str:
    """Return the V4L2 devices of this machine as words for an error line."""
    return ', '.join(sorted(glob.glob('/dev/video*'))) or 'no /dev/video*'


class DeviceSource(FrameSource):
    """A V4L2 device; `read` waits for its next frame, for two seconds at most.

    path: the device itself, what its name stood for when it was opened.
    """

    reconnects = True

    def __init__(self, settings: CameraSettings, now: Callable[[], float] = time.monotonic):
        self.name, self._now = settings.video_device, now
        self._clock_is_sane = True
        self._check_access()
        self.path = os.path.realpath(self.name)
        self._capture = cv2.VideoCapture(self.path, cv2.CAP_V4L2)
        if not self._capture.isOpened():
            self._capture.release()
            raise SourceError(
                'cannot open {}: no V4L2 capture device, or in use by another program (have {}); '
                'set video_device to one of these, a file, or synthetic'
                .format(self.name, list_devices()))
        self._negotiate(settings)

    def _check_access(self) -> None:
        # OpenCV says only "can't open"; open(2) knows why
        try:
            os.close(os.open(self.name, os.O_RDWR | os.O_NONBLOCK))
        except PermissionError as error:
            raise SourceError('cannot open {}: {}; add yourself to the group video, or run as a '
                              'user who may read it'.format(self.name, error.strerror))
        except OSError as error:
            raise SourceError('cannot open {}: {} (have {}); set video_device to one of these, a '
                              'file, or synthetic'
                              .format(self.name, error.strerror, list_devices()))

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
        rate_hz = self._capture.get(cv2.CAP_PROP_FPS)
        self.max_hz = settings.framerate
        self.expected_hz = min(settings.framerate, rate_hz) if rate_hz > 0 else None
        self.stall_timeout_s = max(_SILENCE_S, 3.0 / (self.expected_hz or settings.framerate))
        self.differs = (given, self.width, self.height) != (
            wanted, settings.image_width, settings.image_height)
        self.description = (
            'V4L2 device {}: asked for {} {}x{} at {:g} Hz, got {} {}x{} at {:g} Hz'.format(
                self.name, wanted.strip(), settings.image_width, settings.image_height,
                settings.framerate, given.strip(), self.width, self.height, rate_hz))

    def read(self) -> np.ndarray:
        # in two steps, which tell a device that is gone from a frame that is damaged
        if not self._capture.grab():
            raise SourceError('{} gives no frames: unplugged or silent'.format(self.name))
        captured_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        good, image = self._capture.retrieve()
        if not good or image is None or image.size == 0:
            raise FrameSkipped('{} gave an empty or damaged frame'.format(self.name))
        if image.shape[:2] != (self.height, self.width):
            image = self._shaped(image)
        frame = converted(image, self.encoding)
        self.age_s = self._age_s(captured_s)
        return frame

    def _age_s(self, captured_s: float) -> float:
        # the driver's time of the frame, in most of them by the clock of time.monotonic; one that
        # was wrong once is believed no more, or stamps would jump between two clocks
        age_s = self._now() - captured_s
        self._clock_is_sane = self._clock_is_sane and 0.0 <= age_s <= _MOST_AGE_S
        return age_s if self._clock_is_sane else 0.0

    def _shaped(self, image: np.ndarray) -> np.ndarray:
        # OpenCV hands out formats that it does not convert, such as BGR3, as one long row
        if image.size != self.height * self.width * 3:
            raise FrameSkipped('{} gave a frame of shape {} in place of {}x{}'.format(
                self.name, image.shape, self.width, self.height))
        return image.reshape(self.height, self.width, 3)

    def close(self) -> None:
        self._capture.release()
