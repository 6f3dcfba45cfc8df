"""Frames of films, and of streams from a network, by OpenCV's ffmpeg."""
import re
from typing import Callable

import cv2
import numpy as np

from img_recog.camera.pixels import converted
from img_recog.camera.source import FrameSkipped, FrameSource, SourceEnded, SourceError

NOT_PLAYABLE = ('cannot play {}: neither a film nor an image that OpenCV reads; set video_device '
                'to one, or to synthetic')
_OPEN_TIMEOUT_S, _READ_TIMEOUT_S = 5.0, 2.0
# a stream may pause for longer than a camera: its server sends by whole groups of pictures
_SILENCE_S = 1.8
# What the index of a film counts may differ by a few from what its decoder gives.
_MISSING_SHARE = 0.02
_MISSING_FRAMES = 2


class FilmSource(FrameSource):
    """A film that plays at its own rate, once or in a loop.

    expected_frames: how many its container says that it has, 0 where it does not say.
    """

    def __init__(self, path: str, loop: bool = True, warn: Callable[[str], None] = lambda _: None):
        self._path, self._loop, self._warn = path, loop, warn
        self.name = path
        self._capture = cv2.VideoCapture(path, cv2.CAP_FFMPEG)
        self.rate_hz = self.expected_hz = self._capture.get(cv2.CAP_PROP_FPS)
        self._promised = self._capture.get(cv2.CAP_PROP_FRAME_COUNT)
        self.expected_frames = max(0, int(self._promised))
        self._count = 0
        good, self._next = self._capture.read()
        if not good:
            self._capture.release()
            raise SourceError(NOT_PLAYABLE.format(path))
        if not self.rate_hz > 0:
            self._capture.release()
            raise SourceError('cannot play {}: it does not say its frame rate'.format(path))
        self.height, self.width = self._next.shape[:2]
        self.description = 'film {}, {}x{}, {:g} Hz, played {}'.format(
            path, self.width, self.height, self.rate_hz, 'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        frame = self._next
        if frame is None:
            raise SourceEnded('the film {} is over after {} frames'.format(
                self._path, self._count))
        good, self._next = self._capture.read()
        self._count += 1
        if not good:
            self._check_length()
            self._next = self._first_again() if self._loop else None
        return converted(frame, self.encoding)

    def _first_again(self) -> np.ndarray:
        # opened anew rather than wound back: seeking is inexact in many containers
        self._capture.release()
        self._capture = cv2.VideoCapture(self._path, cv2.CAP_FFMPEG)
        good, image = self._capture.read()
        if not good or image.shape[:2] != (self.height, self.width):
            raise SourceError('{} can no longer be read: moved or replaced while it played'
                              .format(self._path))
        return image

    def _check_length(self) -> None:
        missing = self._promised - self._count
        if missing > max(_MISSING_FRAMES, _MISSING_SHARE * self._promised):
            self._warn('the film {} breaks off after {} of {:.0f} frames: truncated or damaged'
                       .format(self._path, self._count, self._promised))
        self._promised = 0      # said once

    def close(self) -> None:
        self._capture.release()


class StreamSource(FrameSource):
    """A live stream from a network; `read` waits for its next frame, for two seconds at most."""

    reconnects = True
    silence_s = _SILENCE_S

    def __init__(self, url: str):
        self.name = name_for_log(url)
        self._capture = cv2.VideoCapture(url, cv2.CAP_FFMPEG, [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(1000 * _OPEN_TIMEOUT_S),
            cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(1000 * _READ_TIMEOUT_S)])
        good, self._next = self._capture.read()
        if not good:
            self._capture.release()
            raise SourceError('cannot open {}: no stream that OpenCV plays, or not within {:g} s; '
                              'is its server running?'.format(self.name, _OPEN_TIMEOUT_S))
        self.height, self.width = self._next.shape[:2]
        rate_hz = self._capture.get(cv2.CAP_PROP_FPS)
        self.expected_hz = rate_hz if 0 < rate_hz <= 1000 else None
        self.description = 'stream {}, {}x{}'.format(self.name, self.width, self.height)

    def read(self) -> np.ndarray:
        frame, self._next = self._next, None
        if frame is None:
            if not self._capture.grab():
                raise SourceError('{} gives no more frames: ended or silent'.format(self.name))
            good, frame = self._capture.retrieve()
            if not good or frame is None or frame.size == 0:
                raise FrameSkipped('{} gave an empty or damaged frame'.format(self.name))
        if frame.shape[:2] != (self.height, self.width):
            raise SourceError('{} has changed its size to {}x{}'.format(
                self.name, frame.shape[1], frame.shape[0]))
        return converted(frame, self.encoding)

    def close(self) -> None:
        self._capture.release()


def name_for_log(name: str) -> str:
    """Return what `video_device` names as it may stand in a log: without a password."""
    return re.sub(r'(?<=://)[^/@]*@', '', name)
