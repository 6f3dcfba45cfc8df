"""Frames of a video, read by OpenCV's ffmpeg."""
import contextlib
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Callable, Optional, Tuple

import cv2
import numpy as np

from img_recog.camera.source import FrameSource, SourceEnded, SourceError, check_size, convert
from img_recog.camera.urls import redacted
from img_recog.still_images import DEFAULT_MAX_PIXELS

# The frame count in a video's index may differ by a few from what its decoder gives.
_MISSING_SHARE = 0.02
_MISSING_FRAMES = 2
_AHEAD_S = 1.0          # before its end, a video that plays in a loop is opened again

_Opened = Tuple[cv2.VideoCapture, np.ndarray]       # and the first frame


def check_capture(capture: cv2.VideoCapture, name: str, max_pixels: int) -> None:
    """Check the size that an open video states; to be called before a frame is decoded.

    Raises SourceTooLarge when it has more than `max_pixels` pixels; `name` is named.
    """
    check_size('cannot play ' + name, capture.get(cv2.CAP_PROP_FRAME_WIDTH),
               capture.get(cv2.CAP_PROP_FRAME_HEIGHT), max_pixels)


def not_playable(name: str) -> SourceError:
    """Return the error for a file that OpenCV cannot read."""
    return SourceError('cannot play {}: neither a video nor an image that OpenCV reads'.format(
        name), 'set video_device to one, or to synthetic')


class VideoSource(FrameSource):
    """A video that plays at its own rate, once or in a loop.

    rate_hz: the frame rate of the video.
    expected_frames: the frame count that its container states, 0 where it states none.
    """

    rate_hz: float
    _unreadable = '{} can no longer be read: moved or replaced while it played'
    _incomplete = 'truncated or damaged'
    _opens_ahead = True

    def __init__(self, path: str, loop: bool = True, warn: Callable[[str], None] = lambda _: None,
                 max_pixels: int = DEFAULT_MAX_PIXELS,
                 capture: Optional[cv2.VideoCapture] = None):
        """Open a video; raise SourceError when it cannot be played.

        warn: called with one line when the video turns out to be incomplete.
        max_pixels: a video whose frames have more pixels cannot be played.
        capture: if the video is open already.
        """
        self._path, self._loop, self._warn, self._max_pixels = path, loop, warn, max_pixels
        self.name = redacted(path)
        self._ahead: 'Optional[Future[_Opened]]' = None
        self._capture = capture or self._open()
        try:
            check_capture(self._capture, self.name, max_pixels)
            self.rate_hz = self.expected_hz = self._capture.get(cv2.CAP_PROP_FPS)
            self._stated_frames = self._capture.get(cv2.CAP_PROP_FRAME_COUNT)
            self.expected_frames = max(0, int(self._stated_frames))
            self._count = self._position = 0        # frames that were read; since the last start
            first = self._read_frame(self._capture)
            if first is None:
                raise self._not_playable()
            if not self.rate_hz > 0:
                raise SourceError('cannot play {}: its frame rate is not known'.format(self.name))
        except SourceError:
            self._capture.release()
            raise
        self._next: Optional[np.ndarray] = first
        self.height, self.width = first.shape[:2]
        self.description = 'video {}, {}x{}, {:g} Hz, played {}'.format(
            self.name, self.width, self.height, self.rate_hz, 'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        frame = self._next
        if frame is None:
            raise SourceEnded('the video {} has ended after {} frames'.format(
                self.name, self._count))
        self._next = self._read_frame(self._capture)
        self._count += 1
        self._position += 1
        if self._next is None:
            self._check_length()
            self._next = self._rewind() if self._loop else None
        elif self._loop and self._ahead is None and self._opens_ahead and (
                0 <= self.expected_frames - self._position <= _AHEAD_S * self.rate_hz):
            # in a thread: it takes longer than a frame is shown
            executor = ThreadPoolExecutor(1)
            self._ahead = executor.submit(self._open_again)
            executor.shutdown(wait=False)
        return convert(frame, self.encoding)

    def _open(self) -> cv2.VideoCapture:
        return cv2.VideoCapture(self._path, cv2.CAP_FFMPEG)

    def _not_playable(self) -> SourceError:
        return not_playable(self.name)

    def _read_frame(self, capture: cv2.VideoCapture) -> Optional[np.ndarray]:
        decoded, image = capture.read()
        if not decoded:
            return None
        check_size('cannot play ' + self.name, image.shape[1], image.shape[0], self._max_pixels)
        return image

    def _rewind(self) -> np.ndarray:
        # reopened, because seeking is inexact in many containers
        self._capture.release()
        ahead, self._ahead = self._ahead, None
        self._capture, image = ahead.result() if ahead else self._open_again()
        self._position = 0
        return image

    def _open_again(self) -> _Opened:
        capture = self._open()
        try:
            check_capture(capture, self.name, self._max_pixels)
            image = self._read_frame(capture)
            if image is None or image.shape[:2] != (self.height, self.width):
                raise SourceError(self._unreadable.format(self.name))
        except BaseException:
            capture.release()
            raise
        return capture, image

    def _check_length(self) -> None:
        missing = self._stated_frames - self._count
        if missing > max(_MISSING_FRAMES, _MISSING_SHARE * self._stated_frames):
            self._warn('the video {} breaks off after {} of {:.0f} frames: {}'.format(
                self.name, self._count, self._stated_frames, self._incomplete))
        self._stated_frames = 0     # warn only once

    def close(self) -> None:
        ahead, self._ahead = self._ahead, None
        if ahead is not None:
            with contextlib.suppress(Exception):    # what would have ended the video
                ahead.result()[0].release()
        self._capture.release()
