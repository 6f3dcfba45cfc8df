"""What the programs that read recordings have in common: their parts, and what is said of them."""
import argparse
import functools
import logging
import os
from collections import Counter
from typing import Any, List, Mapping, NamedTuple, Sequence, Tuple

from img_recog.batch.engine import Engine
from img_recog.batch.work import Piece
from img_recog.recordings import parts
from img_recog.recordings.frames import Part, Remarks


def unique(forms: Sequence[Sequence[str]]) -> List[str]:
    """Return the first form of each value that no other has, else its last one.

    The last forms of two values differ.

    >>> unique([['a', 'x/a'], ['a', 'y/a'], ['b', 'x/b']])
    ['x/a', 'y/a', 'b']
    """
    counts = Counter(form for each in forms for form in set(each))
    return [next((form for form in each if counts[form] == 1), each[-1]) for each in forms]


def of_path(path: str) -> List[str]:
    """Return the end of a path with more and more folders.

    >>> of_path('/data/a.bag')
    ['a.bag', 'data/a.bag', '/data/a.bag']
    """
    parts = path.split(os.sep)
    return [os.sep.join(parts[-length:]) for length in range(1, len(parts) + 1)]


def of_value(value: Any) -> List[str]:
    """Return the forms of a path, a number or another value.

    >>> of_value('/a/b.yaml')
    ['b', 'b.yaml', 'a/b', 'a/b.yaml', '/a/b', '/a/b.yaml']
    """
    if isinstance(value, str):
        return [form for path in of_path(value) for form in (os.path.splitext(path)[0], path)]
    if isinstance(value, float):
        return ['{:.{}g}'.format(value, digits) for digits in range(6, 18)]
    return [str(value), repr(value)]


class RecordingPart(NamedTuple):
    """A part of a recording.

    name, path: of the recording; start_ns: the stamp of its first usable frame.
    """

    name: str
    path: str
    part: Part
    start_ns: int


def divided(engine: Engine, named: Mapping[str, str], given: argparse.Namespace
            ) -> List[RecordingPart]:
    """Return the parts of all recordings that have a usable image.

    named: paths by names; given: the options of recording_names.
    """
    return [RecordingPart(piece.key, piece.files[0], part, start_ns)
            for piece, (found, start_ns) in engine.run(_divide, [
                Piece(name, (given.topic, given.max_image_pixels), (path,))
                for name, path in named.items()], ' recordings') for part in found]


def _divide(paths: Sequence[str], topic: str, max_pixels: int) -> Tuple[List[Part], int]:
    found = parts.divide(paths[0], topic, max_pixels=max_pixels)
    return found, parts.first(paths[0], found, max_pixels).stamp_ns


def said(remarks: Mapping[str, Sequence[Remarks]], log: logging.Logger) -> List[str]:
    """Log what is to be said of recordings, and return it; remarks: on their parts."""
    lines = ['{}: {}'.format(name, line) for name, each in remarks.items()
             for line in functools.reduce(Remarks.plus, each).lines(name)]
    for line in lines:
        log.warning('%s', line)
    return lines


def not_used(problems: Mapping[str, str], lines: Sequence[str]) -> List[str]:
    """Return the part of a report on what could not be used, in Markdown; lines: of `said`."""
    every = ['{}: {}'.format(*each) for each in problems.items()] + list(lines)
    return ['', 'Not used:', '', *('- ' + line for line in every)] if every else []
