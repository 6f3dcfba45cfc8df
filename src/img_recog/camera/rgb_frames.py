"""Decoded frames as arrays, in the colors that each frame states.

A frame may state by which matrix its colors were coded (ITU-R BT.601, BT.709, BT.2020 ...) and
whether its values fill the whole range of a byte. FFmpeg's filter `scale` heeds both, and takes
what states nothing for BT.601 in the limited range. It gives the pixels of the program ffmpeg.
"""
import threading
from fractions import Fraction
from typing import List, Optional, Tuple

import av
import av.filter
import numpy as np

_Kind = Tuple[str, int, int]        # format, width, height
_MAX_IDLE = 4
# PyAV 10's graphs refer to themselves: Python frees their memory and threads late. So those of
# films that are closed wait here for the next one, which may be the same film in a loop.
_idle: List[Tuple[_Kind, 'av.filter.Graph']] = []
_idle_lock = threading.Lock()


class RgbFrames:
    """Converts frames; each may have another format and size."""

    def __init__(self) -> None:
        self._graph: Optional[Tuple[_Kind, av.filter.Graph]] = None

    def array(self, frame: 'av.VideoFrame') -> np.ndarray:
        """Return a frame as rgb8; raise FFmpegError or ValueError if it cannot be converted."""
        kind = frame.format.name, frame.width, frame.height
        if self._graph is None or self._graph[0] != kind:
            self.release()
            self._graph = kind, _taken(kind) or _made(frame)
        graph = self._graph[1]
        try:
            graph.push(frame)
            converted = graph.pull()
        except BaseException:
            self._graph = None      # it would take no other frame
            raise
        plane = converted.planes[0]
        # no copy, unless the rows are padded
        return np.ascontiguousarray(np.ndarray(
            (converted.height, converted.width, 3), np.uint8, plane,
            strides=(plane.line_size, 3, 1)))

    def release(self) -> None:
        """Let others use what it needs; it can be used again."""
        if self._graph is not None:
            with _idle_lock:
                _idle.append(self._graph)
                del _idle[:-_MAX_IDLE]
        self._graph = None


def _taken(kind: _Kind) -> 'Optional[av.filter.Graph]':
    with _idle_lock:
        number = next((number for number, (each, _) in enumerate(_idle) if each == kind), None)
        return None if number is None else _idle.pop(number)[1]


def _made(frame: 'av.VideoFrame') -> 'av.filter.Graph':
    graph = av.filter.Graph()
    filters = [graph.add_buffer(width=frame.width, height=frame.height, format=frame.format,
                                time_base=Fraction(1, 1000)),
               # what OpenCV asks for; one thread, as each process of a batch has one
               graph.add('scale', 'flags=bicubic:threads=1'),
               graph.add('format', 'pix_fmts=rgb24'),
               graph.add('buffersink')]
    for each, following in zip(filters, filters[1:]):
        each.link_to(following)
    graph.configure()
    return graph
