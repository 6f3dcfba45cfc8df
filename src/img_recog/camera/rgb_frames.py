"""Decoded frames as arrays, in the colors that each frame states.

A frame may state by which matrix its colors were coded (ITU-R BT.601, BT.709, BT.2020 ...) and
whether its values fill the whole range of a byte. FFmpeg's filter `scale` heeds both, and takes
what states nothing for BT.601 in the limited range. It gives the pixels of the program ffmpeg.
"""
import os
import threading
import weakref
from typing import List, Optional, Tuple

import av
import av.filter
import numpy as np

# From FFmpeg 7 on, the filters go by the colors that their source states, not by each frame's.
_STATES_COLORS = av.library_versions['libavfilter'] >= (10,)
# format, width, height, and what the source states of colors: the numbers of matrix and range
_Kind = Tuple[str, int, int, Tuple[int, ...]]


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
