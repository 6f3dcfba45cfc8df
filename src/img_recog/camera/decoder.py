"""Decodes the frames of a video or stream, by FFmpeg through PyAV.

OpenCV's VideoCapture converts all frames by the size of the first one: after a change of the size
on the way it gives old pictures or green borders, and does not tell the new size.
"""
import contextlib
import logging
import os
import re
import threading
import weakref
from collections import deque
from typing import Deque, Iterator, List, Optional, Tuple

import av
import av.filter
import av.logging
import cv2
import numpy as np
from av.error import FFmpegError
from av.sidedata.sidedata import SideDataContainer

from img_recog.camera.source import FrameSkipped, check_size, redacted

# From FFmpeg 7 on, the filters go by the colors that their source states, not by each frame's.
_STATES_COLORS = av.library_versions['libavfilter'] >= (10,)
# format, width, height, and what the source states of colors: the numbers of matrix and range
_Kind = Tuple[str, int, int, Tuple[int, ...]]
# An RTSP server sends by UDP otherwise, and frames whose packets are lost are damaged. The second
# one, in microseconds, is for servers of segments, for which a read may take longer.
_OPTIONS = {'rtsp_transport': 'tcp', 'rw_timeout': '5000000'}
# Whether an image is transposed, then mirrored from left to right, and from top to bottom.
_Turn = Tuple[bool, bool, bool]
# By the degrees clockwise.
_TURNS = {90: (True, True, False), 180: (False, True, True), 270: (True, False, True)}

# From 12.0 on, PyAV drops FFmpeg's lines unless asked; earlier ones pass them to Python's logging.
_QUIET = None if av.logging.get_level() is None else av.logging.PANIC
_description_lock = threading.Lock()
logging.getLogger('libav').setLevel(logging.CRITICAL + 1)
av.logging.set_level(_QUIET)


class _Filters:
    """The filters of a thread, for frames of one kind.

    They stay when a film is closed, for the next one, which may be the same film in a loop:
    PyAV 10's graphs refer to themselves, and Python frees their memory and threads late.
    """

    kind: _Kind = ('', 0, 0, ())
    graph: Optional['av.filter.Graph'] = None


class _Own(threading.local):
    def __init__(self) -> None:
        self.filters = _Filters()
        _all[id(self.filters)] = self.filters


_all: 'weakref.WeakValueDictionary[int, _Filters]' = weakref.WeakValueDictionary()
_own = _Own()
# Python frees the values of all other threads in a process that it forks. FFmpeg would wait there
# forever for the threads of a graph, which no fork copies: the child keeps all graphs.
_kept_in_child: List[List[Optional[_Filters]]] = []
os.register_at_fork(before=lambda: _kept_in_child.append([ref() for ref in _all.valuerefs()]),
                    after_in_parent=lambda: _kept_in_child.pop())


def rgb_array(frame: 'av.VideoFrame') -> np.ndarray:
    """Return a frame as rgb8; raise FFmpegError or ValueError if it cannot be converted."""
    kind = (frame.format.name, frame.width, frame.height,
            (int(frame.colorspace), int(frame.color_range)) if _STATES_COLORS else ())
    own = _own.filters
    graph = own.graph if own.graph is not None and own.kind == kind else _made(kind)
    own.kind, own.graph = kind, None        # after an error, it would take no other frame
    graph.push(frame)
    converted = graph.pull()
    own.graph = graph
    plane = converted.planes[0]
    # no copy, unless the rows are padded
    return np.ascontiguousarray(np.ndarray(
        (converted.height, converted.width, 3), np.uint8, plane,
        strides=(plane.line_size, 3, 1)))


def _made(kind: _Kind) -> 'av.filter.Graph':
    graph = av.filter.Graph()
    name, width, height, colors = kind
    stated = ':colorspace={}:range={}'.format(*colors) if colors else ''
    filters = [graph.add('buffer', 'pix_fmt={}:width={}:height={}:time_base=1/1000{}'.format(
                   name, width, height, stated)),
               # what OpenCV asks for; one thread, as each process of a batch has one
               graph.add('scale', 'flags=bicubic:threads=1'),
               graph.add('format', 'pix_fmts=rgb24'),
               graph.add('buffersink')]
    for each, following in zip(filters, filters[1:]):
        each.link_to(following)
    graph.configure()
    return graph


class Decoder:
    """An open video or stream.

    width, height: size of the frames as stated, in pixels, before they are turned upright; 0 if
    unknown. Each frame has its own.
    rate_hz: the rate that is stated or guessed from the first frames, 0 if none.
    frame_count: as stated, without what the edit list of an .mp4 hides, or of the duration at
    this rate; 0 if unknown, as of a live stream.
    codec: its name. is_segmented: whether its frames arrive in segments of seconds (HLS, DASH).
    ticks, time_s: time of the last frame as FFmpeg gives it, in the unit of the stream and in s;
    None if it gives none.
    """

    def __init__(self, url: str, timeouts_s: Optional[Tuple[float, float]] = None):
        """Open a file or URL; raise FFmpegError or ValueError when there is no video.

        timeouts_s: for opening and for a read, None for no limit.
        """
        # not `options`: PyAV 10 has an array of them for each stream, and frees it by the number
        # of streams that it has found meanwhile, which is larger for FLV and MPEG-PS
        self._container = av.open(url, container_options=_OPTIONS, metadata_errors='replace',
                                  timeout=timeouts_s)
        streams = self._container.streams.video
        if not streams:
            self._container.close()
            raise ValueError('no video')
        self._stream = stream = streams[0]
        self._context = stream.codec_context        # None if there is no decoder
        self._frames: Deque[av.VideoFrame] = deque()
        self._packets: Optional[Iterator[av.Packet]] = None
        self.width = self.height = 0
        if self._context is not None:
            # not one thread more than processors, the default: each delays a stream by a frame;
            # and one, as of OpenCV, in a process that is one of many
            self._context.thread_count = cv2.getNumThreads()
            self._context.thread_type = 'AUTO'
            self.width, self.height = self._context.width, self._context.height
        self.codec, self._turn = _description(self._container, stream.index)
        # without times, the average is 25 Hz from FFmpeg 6 on
        average_hz = None if stream.start_time is None else stream.average_rate
        self.rate_hz = float(average_hz or stream.guessed_rate or 0.0)
        duration_s = ((self._container.duration or 0) / av.time_base
                      or float((stream.duration or 0) * stream.time_base))
        self.frame_count = stream.frames or max(0, int(duration_s * self.rate_hz + 0.5))
        self._has_edit_list = 'mp4' in self._container.format.name
        self.is_segmented = self._container.format.name.startswith(('hls', 'dash'))
        if self._has_edit_list and stream.duration and self.rate_hz:
            # what the list hides is in the stated count, but not in the duration of the stream
            shown = int(stream.duration * stream.time_base * self.rate_hz + 0.5)
            self.frame_count = min(self.frame_count, max(1, shown))
        self.ticks: Optional[int] = None
        self.time_s: Optional[float] = None

    def seconds(self, ticks: int) -> float:
        """Return a time in s."""
        return float(ticks * self._stream.time_base)

    def packet_times(self) -> Iterator[Tuple[Optional[int], bool]]:
        """Yield the time in ticks of each frame that is shown, and whether it is a key frame.

        They are in the order of the file, and are not decoded: `read` finds nothing then.
        """
        # what an edit list hides comes before the start
        start = self._stream.start_time if self._has_edit_list else None
        return ((packet.pts, packet.is_keyframe) for packet in self._container.demux(self._stream)
                if packet.size and (packet.pts is None or start is None or packet.pts >= start))

    def seek(self, ticks: int) -> None:
        """Have `read` go on at the last key frame that is not after a time, if it can."""
        self._frames.clear()
        self._packets = None
        with contextlib.suppress(FFmpegError):      # of a container without an index
            self._container.seek(ticks, stream=self._stream)

    def read(self) -> Optional[np.ndarray]:
        """Return the next frame, rgb8 of its own size, upright; None at the end or a timeout.

        Raises FrameSkipped for a damaged frame.
        """
        try:
            if not self._fill():
                return None
            frame = self._frames.popleft()
            self.ticks = frame.dts if frame.pts is None else frame.pts
            self.time_s = None if self.ticks is None else self.seconds(self.ticks)
            image = rgb_array(frame)
        except (FFmpegError, ValueError) as error:
            raise FrameSkipped('{} gave an empty or damaged frame'.format(
                redacted(self._container.name))) from error
        return _upright(image, _turn_of(frame) or self._turn)

    def __enter__(self) -> 'Decoder':
        return self

    def __exit__(self, *_) -> None:
        self.release()

    def release(self) -> None:
        """Close it; no effect when it is closed already."""
        if self._context is not None:
            # PyAV 10 waits for the threads of the decoder with the GIL, which they need for each
            # line that they log: an empty packet lets them finish before
            with contextlib.suppress(FFmpegError):
                self._context.decode(av.Packet())
            # else it keeps its frames until Python collects garbage; PyAV 14 frees them at once
            if hasattr(self._context, 'close'):
                self._context.close(strict=False)
        self._context = self._packets = None
        self._frames.clear()
        self._container.close()

    def _fill(self) -> bool:
        """Decode until there is a frame; return whether there is one."""
        while not self._frames and self._context is not None:
            if self._packets is None:
                self._packets = self._container.demux(self._stream)
            try:
                packet = next(self._packets)
            except StopIteration:
                return False
            except FFmpegError:         # a timeout, or the connection is lost
                self._packets = None
                return False
            self._frames.extend(packet.decode())
        return bool(self._frames)


def open_decoder(path: str, max_pixels: int,
                 timeouts_s: Optional[Tuple[float, float]] = None) -> Optional[Decoder]:
    """Open a video or stream; return None when FFmpeg finds no video there.

    timeouts_s: for opening and for a read, None for no limit.
    Raises SourceTooLarge when it states more than `max_pixels` pixels: no frame is decoded then.
    """
    try:
        decoder = Decoder(path, timeouts_s)
    except (FFmpegError, ValueError):
        return None
    with released_on_error(decoder):
        check_size('cannot play ' + redacted(path), decoder.width, decoder.height, max_pixels)
    return decoder


@contextlib.contextmanager
def released_on_error(decoder: Decoder) -> Iterator[None]:
    """Release `decoder` if the block raises anything."""
    try:
        yield
    except BaseException:
        decoder.release()
        raise


def _turn_of(frame: 'av.VideoFrame') -> Optional[_Turn]:
    """Return how to turn one frame, as the EXIF data of a JPEG say; None if nothing says it."""
    # not frame.side_data, which refers to the frame and back: it would wait for the collector
    data = SideDataContainer(frame).get('DISPLAYMATRIX')
    if data is None:
        return None
    # of libavutil/display.h: x' = a x + c y, y' = b x + d y
    a, b, _, c, d = np.frombuffer(bytes(data), np.int32)[:5]
    return (True, c < 0, b < 0) if b and c else (False, a < 0, d < 0)


def _upright(image: np.ndarray, turn: Optional[_Turn]) -> np.ndarray:
    """Return an image, turned and mirrored."""
    if turn is None:
        return image
    is_transposed, left_right, top_bottom = turn
    if is_transposed:
        image = cv2.transpose(image)
    if left_right or top_bottom:
        image = cv2.flip(image, -1 if left_right and top_bottom else 1 if left_right else 0)
    return image


def _description(container: 'av.container.InputContainer',
                 index: int) -> Tuple[str, Optional[_Turn]]:
    """Return the name of a stream's codec, and how to turn its frames, None if not.

    From FFmpeg's text: PyAV 10 gives no display matrix, and no name where there is no decoder.
    """
    with _description_lock:
        av.logging.set_level(av.logging.INFO)
        try:
            text = container.dumps_format()
        finally:
            av.logging.set_level(_QUIET)
    text = text.partition('Stream #0:{}'.format(index))[2].partition('Stream #')[0]
    codec = re.search(r'Video: (\w+)(?:.*?\((\w+) / 0x)?', text)
    name = '' if codec is None else codec.group(1)
    turned = re.search(r'displaymatrix: rotation of (\S+) degrees', text)
    # counterclockwise there
    degrees = 0 if turned is None else round(-float(turned.group(1))) % 360
    return codec.group(2) or name if codec and name == 'none' else name, _TURNS.get(degrees)
