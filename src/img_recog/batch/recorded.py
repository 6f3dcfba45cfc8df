"""What the programs that read recordings have in common: their parts, and what is said of them."""
import argparse
import functools
import logging
from typing import List, Mapping, NamedTuple, Sequence, Tuple

from img_recog.batch.engine import Engine
from img_recog.batch.work import Piece
from img_recog.recordings import parts
from img_recog.recordings.frames import Part, Remarks


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
