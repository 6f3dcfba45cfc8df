"""A live stream or a video at a URL, decoded by FFmpeg."""
import os
import re
import time
from typing import Callable, Optional
from urllib.parse import urlsplit

import numpy as np

from img_recog.camera.decoder import Decoder, open_decoder, released_on_error
from img_recog.camera.frame_pacing import FrameTimes
from img_recog.camera.image_source import VIDEO_EXTENSIONS
from img_recog.camera.source import (FrameSkipped, FrameSource, RefusedSource, SourceError,
                                     SourceTooLarge, check_size, redacted)
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.camera.video_source import VideoSource
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS

_SCHEMES = 'http', 'https', 'rtmp', 'rtsp', 'rtsps'
# When a read times out, ffmpeg may return a frame made from the data that has arrived.
_OPEN_TIMEOUT_S, _READ_TIMEOUT_S = 5.0, 2.0
# Longer than for a camera: servers may send whole groups of pictures (GOP) at once.
_STALL_TIMEOUT_S = 1.8
# A playlist of HLS or DASH may get its next segment, of up to 10 s, late; FFmpeg waits for it.
_PLAYLIST = re.compile(r'\.(m3u8?|mpd)\b', re.IGNORECASE)
_SEGMENT_READ_TIMEOUT_S, _SEGMENT_STALL_TIMEOUT_S = 30.0, 15.0
# A longer step between two frames is not waited for: segments were skipped.
_MAX_STEP_S, _UNKNOWN_RATE_HZ = 5.0, 25.0


def open_url(settings: UsbCamSettings, warn: Callable[[str], None]) -> FrameSource:
    """Open a live stream or a video (at its own rate).

    Raises SourceError when it is neither, when it has too many pixels, or when the server
    does not answer.
    """
    scheme, _, rest = settings.video_device.partition('://')
    scheme = scheme.lower()     # FFmpeg accepts no other case; RFC 3986, 3.1: it does not matter
    url = _expanded('{}://{}'.format(scheme, rest))
    name, max_pixels = redacted(url), settings.max_image_pixels
    if scheme not in _SCHEMES:
        raise RefusedSource('cannot open {}: the URL of a stream begins with one of {}'.format(
            name, ', '.join(known + '://' for known in _SCHEMES)))
    decoder = open_decoder(url, max_pixels, (
        _OPEN_TIMEOUT_S, _SEGMENT_READ_TIMEOUT_S if _PLAYLIST.search(url) else _READ_TIMEOUT_S))
    if decoder is None:
        raise SourceError('cannot open {}: no stream that FFmpeg plays, or not within {:g} s'
                          .format(name, _OPEN_TIMEOUT_S), 'is its server running?')
    with released_on_error(decoder):
        is_http = scheme.startswith('http')     # the other protocols send at the video's rate
        # the frame count of a live stream is not known, nor that of some videos, as of a browser
        count = decoder.frame_count
        if is_http and (count > 1 or urlsplit(url).path.lower().endswith(VIDEO_EXTENSIONS)):
            return RemoteVideoSource(url, decoder, settings.loop, warn, max_pixels=max_pixels)
        return StreamSource(name, decoder, announces_rate=not is_http, max_pixels=max_pixels)


def _expanded(url: str) -> str:
    """Return a URL with the values of the environment variables that it names as ${NAME}."""
    try:
        return re.sub(r'\$\{(\w+)\}', lambda found: os.environ[found.group(1)], url)
    except KeyError as error:
        raise RefusedSource('cannot open {}: the environment variable {} is not set'.format(
            redacted(url), error.args[0]), 'export it in the terminal of roslaunch')


class RemoteVideoSource(VideoSource):
    """A video at a URL; when it plays in a loop, it is reopened after its server has stalled."""

    _incomplete = 'truncated or damaged, or its server closed the connection'

    def __init__(self, url: str, decoder: Decoder, loop: bool,
                 warn: Callable[[str], None], now: Callable[[], float] = time.monotonic,
                 max_pixels: int = DEFAULT_MAX_PIXELS):
        """Play the video that `decoder` has just opened at `url`."""
        self._now = now
        self.reconnects = loop      # a video that plays once must not start again
        self.stall_timeout_s = _STALL_TIMEOUT_S if loop else None
        super().__init__(url, loop, warn, max_pixels, decoder)

    def _not_playable(self) -> SourceError:
        return SourceError(
            'cannot play {}: FFmpeg decodes no frame of it (codec {}): it has no decoder for '
            'that, or the server has no range requests and the index of the .mp4 is at its end'
            .format(self.name, self._decoder.codec))

    def _read_frame(self) -> Optional[np.ndarray]:
        begin_s = self._now()
        image = super()._read_frame()
        silent_s = self._now() - begin_s
        if silent_s >= _READ_TIMEOUT_S:
            raise SourceError('the video {} stalls: its server has sent nothing for {:.1f} s'
                              .format(self.name, silent_s))
        return image


class StreamSource(FrameSource):
    """A live stream; `read` waits for the next frame, for at most two seconds.

    A damaged frame is skipped. 1.8 s without a good frame are the end of the stream. One whose
    frames arrive in segments plays at the times of its frames, and may stand for longer.
    """

    reconnects = True
    stall_timeout_s: float

    def __init__(self, name: str, decoder: Decoder, announces_rate: bool = False,
                 now: Callable[[], float] = time.monotonic,
                 max_pixels: int = DEFAULT_MAX_PIXELS):
        """Play the stream that `decoder` has just opened; it stays open if that fails.

        announces_rate: whether its protocol announces the rate; otherwise FFmpeg's is a guess.
        max_pixels: a frame with more pixels ends the stream.
        """
        self.name, self._decoder, self._now, self._max_pixels = name, decoder, now, max_pixels
        self._count = 0
        self._last_s = now()        # when there was a good frame
        self.stall_timeout_s = _STALL_TIMEOUT_S
        if decoder.is_segmented:        # each is complete when it arrives
            self.stall_timeout_s = _SEGMENT_STALL_TIMEOUT_S
            self.rate_hz = decoder.rate_hz or _UNKNOWN_RATE_HZ
        self._times = FrameTimes(decoder.rate_hz or _UNKNOWN_RATE_HZ, _MAX_STEP_S)
        self._next: Optional[np.ndarray] = None
        while self._next is None:
            try:
                self._next = self.read()
            except FrameSkipped:
                continue
            except SourceTooLarge:
                raise
            except SourceError:
                raise SourceError('cannot open {}: no frame arrives that FFmpeg decodes (codec {})'
                                  .format(name, decoder.codec))
        rate_hz = decoder.rate_hz
        self.expected_hz = rate_hz if announces_rate and 0 < rate_hz <= 1000 else None
        self.description = 'stream {}, {}x{}'.format(name, self.width, self.height)

    def read(self) -> np.ndarray:
        frame, self._next = self._next, None
        if frame is not None:
            return frame
        begin_s = self._now()
        try:
            frame = self._decoder.read()
        except FrameSkipped:
            if self._now() - self._last_s < self.stall_timeout_s:
                raise
        now_s = self._now()
        if frame is None or now_s - begin_s >= max(_READ_TIMEOUT_S, self.stall_timeout_s):
            problem = '{} gives no more frames: ended or silent'.format(self.name)
            if self._count == 1:
                raise SourceError(problem + ' after the first',
                                  'give a stream or a video; an image has to be a file')
            raise SourceError(problem)
        check_size('cannot play ' + self.name, frame.shape[1], frame.shape[0], self._max_pixels)
        self._count += 1
        self._last_s = now_s
        self.time_s = self._times.next_s(self._decoder.time_s)
        self.height, self.width = frame.shape[:2]
        return frame

    def close(self) -> None:
        self._decoder.release()
