"""Frames of a V4L2 device, read by OpenCV."""
import glob
import os
import time
from typing import Callable

import cv2
import numpy as np

from img_recog.camera.source import FrameSkipped, FrameSource, SourceError, convert, fourcc
from img_recog.camera.usb_cam_settings import FOURCC, GREY_FORMATS, UsbCamSettings
from img_recog.errors import one_line

# A read that takes longer than this, and than three periods of a slow camera, is a stall.
_MIN_STALL_TIMEOUT_S = 1.5
# OpenCV holds four frames: one that seems to be older has a stamp of another clock.
_MAX_AGE_S = 2.0
_ADVICE = 'give one of these, a file, or synthetic'


def list_devices() -> str:
    """Return the V4L2 devices of this machine, as text for an error line."""
    found = sorted(glob.glob('/dev/video*'))
    return 'there {} {}'.format('are' if len(found) > 1 else 'is',
                                ', '.join(found) or 'no /dev/video*')


class DeviceSource(FrameSource):
    """A V4L2 device; `read` waits for the next frame, for at most two seconds.

    path: the device file, with the symlinks of the name resolved when it was opened.
    """

    reconnects = True

    def __init__(self, settings: UsbCamSettings, now: Callable[[], float] = time.monotonic):
        self.name, self._now = settings.video_device, now
        self._clock_is_valid = True
        self._check_access()
        self.path = os.path.realpath(self.name)
        self._capture = cv2.VideoCapture(self.path, cv2.CAP_V4L2)
        if not self._capture.isOpened():
            self._capture.release()
            raise SourceError(
                'cannot open {}: no V4L2 capture device, or in use by another program ({})'
                .format(self.name, list_devices()), _ADVICE)
        self._negotiate(settings)

    def _check_access(self) -> None:
        # OpenCV reports only "can't open"; open(2) gives the reason
        try:
            os.close(os.open(self.name, os.O_RDWR | os.O_NONBLOCK))
        except PermissionError as error:
            raise SourceError('cannot open {}: {}'.format(self.name, one_line(error)),
                              'add your user to the group video, or run as one who can read it')
        except OSError as error:
            raise SourceError('cannot open {}: {} ({})'.format(
                self.name, one_line(error), list_devices()), _ADVICE)

    def _negotiate(self, settings: UsbCamSettings) -> None:
        # the format first: the sizes and rates that a camera offers depend on it
        wanted = FOURCC[settings.pixel_format]
        # OpenCV would give H.264 of a device as it is, without decoding it
        requested = FOURCC['mjpeg'] if settings.pixel_format == 'h264' else wanted
        self._capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*requested))
        self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, settings.image_width)
        self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, settings.image_height)
        self._capture.set(cv2.CAP_PROP_FPS, settings.framerate)
        self.encoding = 'mono8' if settings.pixel_format in GREY_FORMATS else 'rgb8'
        self.width = int(self._capture.get(cv2.CAP_PROP_FRAME_WIDTH))
        self.height = int(self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
        given = fourcc(self._capture)
        rate_hz = self._capture.get(cv2.CAP_PROP_FPS)
        self.max_hz = settings.framerate
        self.expected_hz = min(settings.framerate, rate_hz) if rate_hz > 0 else None
        self.stall_timeout_s = max(_MIN_STALL_TIMEOUT_S,
                                   3.0 / (self.expected_hz or settings.framerate))
        self.differs = (given, self.width, self.height) != (
            wanted.strip(), settings.image_width, settings.image_height)
        self.description = (
            'V4L2 device {}: asked for {} {}x{} at {:g} Hz, got {} {}x{} at {:g} Hz'.format(
                self.name, wanted.strip(), settings.image_width, settings.image_height,
                settings.framerate, given, self.width, self.height, rate_hz))

    def read(self) -> np.ndarray:
        # two steps, to distinguish a lost device from a damaged frame
        if not self._capture.grab():
            raise SourceError('{} gives no frames: unplugged or silent'.format(self.name))
        captured_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000.0
        decoded, image = self._capture.retrieve()
        if not decoded or image is None or image.size == 0:
            raise FrameSkipped('{} gave an empty or damaged frame'.format(self.name))
        if image.shape[:2] != (self.height, self.width):
            image = self._reshape(image)
        frame = convert(image, self.encoding)
        self.age_s = self._age_s(captured_s)
        return frame

    def _age_s(self, captured_s: float) -> float:
        # Most drivers stamp frames by the clock of time.monotonic. After one stamp that cannot be
        # right they are ignored: else the published stamps would jump between two clocks.
        age_s = self._now() - captured_s
        self._clock_is_valid = self._clock_is_valid and 0.0 <= age_s <= _MAX_AGE_S
        return age_s if self._clock_is_valid else 0.0

    def _reshape(self, image: np.ndarray) -> np.ndarray:
        # OpenCV returns formats that it does not convert, such as BGR3, as one row
        if image.size != self.height * self.width * 3:
            raise FrameSkipped('{} gave a frame of shape {} instead of {}x{}'.format(
                self.name, image.shape, self.width, self.height))
        return image.reshape(self.height, self.width, 3)

    def close(self) -> None:
        self._capture.release()
