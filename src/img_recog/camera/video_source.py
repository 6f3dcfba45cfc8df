"""Frames of videos, by OpenCV's ffmpeg."""
from typing import Callable, Optional

import cv2
import numpy as np

from img_recog.camera.pixels import converted
from img_recog.camera.source import FrameSource, SourceEnded, SourceError
from img_recog.camera.urls import redacted

NOT_PLAYABLE = ('cannot play {}: neither a video nor an image that OpenCV reads; set video_device '
                'to one, or to synthetic')
# What the index of a video counts may differ by a few from what its decoder gives.
_MISSING_SHARE = 0.02
_MISSING_FRAMES = 2


class VideoSource(FrameSource):
    """A video that plays at its own rate, once or in a loop.

    expected_frames: how many its container says that it has, 0 where it does not say.
    """

    _not_playable = NOT_PLAYABLE
    _gone = '{} can no longer be read: moved or replaced while it played'
    _cut = 'truncated or damaged'

    def __init__(self, path: str, loop: bool = True, warn: Callable[[str], None] = lambda _: None):
        self._path, self._loop, self._warn = path, loop, warn
        self.name = redacted(path)
        self._capture = self._open()
        try:
            self.rate_hz = self.expected_hz = self._capture.get(cv2.CAP_PROP_FPS)
            self._promised = self._capture.get(cv2.CAP_PROP_FRAME_COUNT)
            self.expected_frames = max(0, int(self._promised))
            self._count = 0
            self._next = self._following()
            if self._next is None:
                raise SourceError(self._not_playable.format(self.name))
            if not self.rate_hz > 0:
                raise SourceError('cannot play {}: it does not say its frame rate'.format(
                    self.name))
        except SourceError:
            self._capture.release()
            raise
        self.height, self.width = self._next.shape[:2]
        self.description = 'video {}, {}x{}, {:g} Hz, played {}'.format(
            self.name, self.width, self.height, self.rate_hz, 'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        frame = self._next
        if frame is None:
            raise SourceEnded('the video {} is over after {} frames'.format(
                self.name, self._count))
        self._next = self._following()
        self._count += 1
        if self._next is None:
            self._check_length()
            self._next = self._first_again() if self._loop else None
        return converted(frame, self.encoding)

    def _open(self) -> cv2.VideoCapture:
        return cv2.VideoCapture(self._path, cv2.CAP_FFMPEG)

    def _following(self) -> Optional[np.ndarray]:
        good, image = self._capture.read()
        return image if good else None

    def _first_again(self) -> np.ndarray:
        # opened anew rather than wound back: seeking is inexact in many containers
        self._capture.release()
        self._capture = self._open()
        image = self._following()
        if image is None or image.shape[:2] != (self.height, self.width):
            raise SourceError(self._gone.format(self.name))
        return image

    def _check_length(self) -> None:
        missing = self._promised - self._count
        if missing > max(_MISSING_FRAMES, _MISSING_SHARE * self._promised):
            self._warn('the video {} breaks off after {} of {:.0f} frames: {}'.format(
                self.name, self._count, self._promised, self._cut))
        self._promised = 0      # said once

    def close(self) -> None:
        self._capture.release()
