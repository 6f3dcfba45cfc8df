"""What the programs that read recordings have in common: their parts, and what is said of them."""
import functools
import logging
from typing import List, Mapping, NamedTuple, Sequence

from img_recog.recordings import parts
from img_recog.recordings.frames import Part, Remarks


class Divided(NamedTuple):
    """The parts of a recording; start_ns: the stamp of its first usable frame."""

    parts: List[Part]
    start_ns: int


def divide(paths: Sequence[str], topic: str, max_pixels: int) -> Divided:
    """Return the parts of a recording that has a usable image; for the engine."""
    divided = parts.divide(paths[0], topic, max_pixels=max_pixels)
    return Divided(divided, parts.first(paths[0], divided, max_pixels).stamp_ns)


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
