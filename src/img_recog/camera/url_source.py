"""What is at a URL: a live stream, a video or a picture, by OpenCV's ffmpeg."""
import time
from typing import Callable, Optional, Tuple

import cv2
import numpy as np

from img_recog.camera import urls
from img_recog.camera.image_source import EXTENSIONS, ImageSource
from img_recog.camera.pixels import converted
from img_recog.camera.source import FrameSkipped, FrameSource, SourceError
from img_recog.camera.video_source import VideoSource

# when the time for a read is over, ffmpeg may make a frame of the part that has come
_OPEN_TIMEOUT_S, _READ_TIMEOUT_S = 5.0, 2.0
# a stream may pause for longer than a camera: its server sends by whole groups of pictures
_SILENCE_S = 1.8
# OpenCV says the same of a damaged frame and of the end, but at the end it says so again at once
_AT_ONCE_S, _FAILURES_AT_THE_END = 0.005, 4
# A video whose container does not say how many frames it has, as a recording by a browser.
_VIDEO_EXTENSIONS = ('.avi', '.m4v', '.mkv', '.mov', '.mp4', '.mpeg', '.mpg', '.ogv', '.webm')


def open_url(url: str, rate_hz: float, loop: bool = True,
             warn: Callable[[str], None] = lambda _: None) -> FrameSource:
    """Open a live stream, a video (at its own rate) or a picture (fetched once, for `rate_hz`).

    Raises SourceError when it is none of them, or does not answer.
    """
    scheme, url = urls.split(url)
    name = urls.redacted(url)
    if scheme not in urls.SCHEMES:
        raise SourceError('cannot open {}: the URL of a stream begins with one of {}'.format(
            name, ', '.join(each + '://' for each in urls.SCHEMES)))
    capture = _open_capture(url)
    if not capture.isOpened():
        capture.release()
        raise SourceError('cannot open {}: no stream that OpenCV plays, or not within {:g} s; '
                          'is its server running?'.format(name, _OPEN_TIMEOUT_S))
    if not scheme.startswith('http'):       # the others send at the rate of the video
        return StreamSource(name, capture, announces_rate=True)
    # a video says how many frames it has; of a live stream ffmpeg says zero or something absurd
    count = capture.get(cv2.CAP_PROP_FRAME_COUNT)
    if count > 1 or urls.ends_with(url, _VIDEO_EXTENSIONS):
        return RemoteVideoSource(url, capture, loop, warn)
    stream = StreamSource(name, capture)
    if count == 1 or urls.ends_with(url, EXTENSIONS):
        return _image_or_stream(stream, rate_hz)
    return stream


def _open_capture(url: str) -> cv2.VideoCapture:
    return cv2.VideoCapture(url, cv2.CAP_FFMPEG, [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(1000 * _OPEN_TIMEOUT_S),
        cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(1000 * _READ_TIMEOUT_S)])


def _image_or_stream(stream: 'StreamSource', rate_hz: float) -> FrameSource:
    # some cameras call their stream a .jpg too: a picture is what has one frame alone
    images = []
    while len(images) < 2:
        try:
            images.append(stream.read())
        except FrameSkipped:
            continue
        except SourceError:
            stream.close()
            return ImageSource(stream.name, images[0], rate_hz)
    return stream


class RemoteVideoSource(VideoSource):
    """A video at a URL. When its server stalls, one that plays in a loop is waited for."""

    _not_playable = ('cannot play {}: no video that OpenCV reads from there (a server without '
                     'range requests cannot serve an .mp4 whose index is at its end)')
    _gone = '{} can no longer be read: its server is gone, or has another video now'
    _cut = 'truncated or damaged, or its server hung up'

    def __init__(self, url: str, capture: cv2.VideoCapture, loop: bool,
                 warn: Callable[[str], None], now: Callable[[], float] = time.monotonic):
        """Play what `capture` has just opened at `url`."""
        self._opened: Optional[cv2.VideoCapture] = capture
        self._now = now
        self.reconnects = loop      # one that plays once is not to begin again
        self.stall_timeout_s = _SILENCE_S if loop else None
        super().__init__(url, loop, warn)

    def _open(self) -> cv2.VideoCapture:
        opened, self._opened = self._opened, None
        return opened or _open_capture(self._path)

    def _following(self) -> Optional[np.ndarray]:
        begin_s = self._now()
        image = super()._following()
        silent_s = self._now() - begin_s
        if silent_s >= _READ_TIMEOUT_S:
            raise SourceError('the video {} stalls: its server has sent nothing for {:.1f} s'
                              .format(self.name, silent_s))
        return image


class StreamSource(FrameSource):
    """A live stream from a network; `read` waits for its next frame, for two seconds at most.

    A damaged frame is skipped. Some at once are the end of the stream, as is a time without any.
    """

    reconnects = True
    stall_timeout_s = _SILENCE_S

    def __init__(self, name: str, capture: cv2.VideoCapture, announces_rate: bool = False,
                 now: Callable[[], float] = time.monotonic):
        """Play what `capture` has just opened.

        announces_rate: whether its protocol says the rate; else what OpenCV says is a guess.
        """
        self.name, self._capture, self._now = name, capture, now
        self._count = 0
        try:
            self._next, self._damaged = self._grabbed()
        except SourceError:
            capture.release()
            raise SourceError('cannot open {}: no frame comes that OpenCV reads'.format(name))
        self.height, self.width = self._next.shape[:2]
        rate_hz = capture.get(cv2.CAP_PROP_FPS)
        self.expected_hz = rate_hz if announces_rate and 0 < rate_hz <= 1000 else None
        self.description = 'stream {}, {}x{}'.format(name, self.width, self.height)

    def read(self) -> np.ndarray:
        if self._next is None:
            self._next, self._damaged = self._grabbed()
        if self._damaged > 0:
            self._damaged -= 1
            raise FrameSkipped('{} gave an empty or damaged frame'.format(self.name))
        frame, self._next = self._next, None
        if frame.shape[:2] != (self.height, self.width):
            raise SourceError('{} has changed its size to {}x{}'.format(
                self.name, frame.shape[1], frame.shape[0]))
        return converted(frame, self.encoding)

    def _grabbed(self) -> Tuple[np.ndarray, int]:
        """Return the next good frame, and how many before it were not."""
        begin_s = now_s = self._now()
        damaged = at_once = 0
        while at_once < _FAILURES_AT_THE_END and now_s - begin_s < _SILENCE_S:
            before_s = now_s
            good, frame = self._capture.read()
            now_s = self._now()
            in_time = now_s - before_s < _READ_TIMEOUT_S
            if good and in_time and frame is not None and frame.size > 0:
                self._count += 1
                return frame, damaged
            damaged += 1
            at_once += now_s - before_s < _AT_ONCE_S
        raise SourceError('{} gives no more frames: ended or silent{}'.format(
            self.name, ' after the first; a stream is wanted, not a picture'
            if self._count == 1 else ''))

    def close(self) -> None:
        self._capture.release()
