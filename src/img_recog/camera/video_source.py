"""Frames of a video, decoded by FFmpeg."""
import os
from collections import deque
from typing import Callable, Deque, Optional, Tuple

import numpy as np

from img_recog.camera.decoder import Decoder, open_decoder, released_on_error
from img_recog.camera.frame_pacing import FrameTimes
from img_recog.camera.source import (FrameSkipped, FrameSource, SourceEnded, SourceError,
                                     check_size, redacted)
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS

# The frame count in a video's index may differ by a few from what its decoder gives.
_MISSING_SHARE = 0.02
_MISSING_FRAMES = 2
_MAX_DAMAGED_FRAMES = 4096      # in a row; then it is a video no longer


def not_playable(name: str) -> SourceError:
    """Return the error for a file that is neither a video nor an image."""
    return SourceError('cannot play {}: neither a video nor an image that OpenCV reads'.format(
        name), 'give one, or synthetic')


class VideoSource(FrameSource):
    """A video that plays at the times of its frames; damaged ones are skipped.

    rate_hz: the frame rate of the video; if it varies, that of the first two frames.
    expected_hz: the same, None if it varies.
    time_s: as the decoder gives it; number / rate_hz where it gives none.
    expected_frames: the frame count that its container states, 0 where it states none.
    """

    rate_hz: float
    time_s: float = 0.0
    step_s: float
    _incomplete = 'truncated or damaged'

    def __init__(self, path: str, loop: bool = True, warn: Callable[[str], None] = lambda _: None,
                 max_pixels: int = DEFAULT_MAX_PIXELS,
                 decoder: Optional[Decoder] = None):
        """Open a video; raise SourceError when it cannot be played.

        warn: called with one line when the video turns out to be incomplete.
        max_pixels: a video whose frames have more pixels cannot be played.
        decoder: if the video is open already.
        """
        self.name, self.loops = redacted(path), loop
        self._warn, self._max_pixels = warn, max_pixels
        self._count = self.damaged = self._damaged = 0
        # ffmpeg takes what is before a colon for a protocol, but not in an absolute path
        opened = decoder or open_decoder(os.path.abspath(path), max_pixels)
        if opened is None:
            raise not_playable(self.name)
        self._decoder = opened
        with released_on_error(self._decoder):
            first = self._read_frame()
            if first is None:
                raise self._not_playable()
            stated_hz = self._decoder.rate_hz
            self._times = FrameTimes(stated_hz)
            # with the times, and damaged frames before; None: the end
            self._next: Deque[Optional[Tuple[np.ndarray, float, int]]] = deque()
            self._append(first)
            self._append(self._read_frame())
            self.step_s = self._times.step_s
            if not self.step_s > 0:
                raise SourceError('cannot play {}: neither its frame rate nor the times of its '
                                  'frames are known'.format(self.name),
                                  'convert it: ffmpeg -r RATE -i INPUT OUTPUT.mp4')
        is_even = self._times.is_even()
        self.rate_hz = stated_hz if is_even else 1.0 / self.step_s
        self.expected_hz = stated_hz if is_even else None
        self.expected_frames = self._decoder.frame_count
        self._expected_s = self.expected_frames / stated_hz if stated_hz > 0 else 0.0
        self.height, self.width = first.shape[:2]
        self.description = 'video {}, {}x{}, {}, played {}'.format(
            self.name, self.width, self.height,
            '{:g} Hz'.format(stated_hz) if is_even else 'variable rate',
            'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        following = self._next.popleft()
        if following is None:
            self._next.append(None)
            self.damaged = self._damaged
            raise SourceEnded('the video {} has ended after {} frames'.format(
                self.name, self._count))
        frame, self.time_s, self.damaged = following
        self._count += 1
        if not self._next:
            self._append(self._read_frame())
        if self._next[0] is None:
            self._check_length()
        self.step_s = self._times.step_s
        self.height, self.width = frame.shape[:2]
        return frame

    def _append(self, image: Optional[np.ndarray]) -> None:
        self._next.append(None if image is None else (
            image, self._times.next_s(self._decoder.time_s), self._damaged))

    def _not_playable(self) -> SourceError:
        return SourceError(
            'cannot play {}: FFmpeg decodes no frame of it (codec {}): it has no decoder for '
            'that, or the file is damaged'.format(self.name, self._decoder.codec),
            'convert it: ffmpeg -i INPUT -c:v libx264 OUTPUT.mp4')

    def _read_frame(self) -> Optional[np.ndarray]:
        for _ in range(_MAX_DAMAGED_FRAMES):
            try:
                image = self._decoder.read()
            except FrameSkipped:
                self._damaged += 1
                continue
            if image is not None:
                check_size('cannot play ' + self.name, image.shape[1], image.shape[0],
                           self._max_pixels)
            return image
        return None

    def _check_length(self) -> None:
        # of some containers the frame count is that of their duration at a constant rate
        missing = self.expected_frames - self._count
        missing_s = self._expected_s - self.time_s - self._times.longest_step_s
        if (missing > max(_MISSING_FRAMES, _MISSING_SHARE * self.expected_frames)
                and missing_s > _MISSING_SHARE * self._expected_s):
            self._warn('the video {} breaks off after {} of {} frames: {}'.format(
                self.name, self._count, self.expected_frames, self._incomplete))

    def close(self) -> None:
        self._decoder.release()
