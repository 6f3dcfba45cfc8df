"""Samples: where in recordings a color is, and when it is in view."""
import os
from typing import Any, NamedTuple, Sequence, Tuple

from img_recog.errors import UserError, suggestion

# in place of a color: of a part that has none of them, and of one that is not used
NO_COLOR, IGNORED = 'none', 'ignored'


class SampleError(UserError):
    """A file of samples, or an entry of it, cannot be used; names the file and the entry."""


class Region(NamedTuple):
    """A part of a frame that has a color, or is NO_COLOR or IGNORED.

    entry: as messages name it; frame: number of the frame, from 0.
    outline: corners (x, y) in pixels of a rectangle or polygon, whose edges belong to it; mask:
    a PNG, in which pixels that are not black belong to it. One of both is given.
    """

    entry: str
    color: str
    frame: int
    outline: Tuple[Tuple[float, float], ...]
    mask: bytes


def corners(left: float, top: float, width: float, height: float
            ) -> Tuple[Tuple[float, float], ...]:
    """Return the corners of a rectangle in pixels, which belong to it."""
    right, bottom = left + width - 1, top + height - 1
    return (left, top), (right, top), (right, bottom), (left, bottom)


class TimeRange(NamedTuple):
    """A range of time in which a color is in view or not, in s from the first frame."""

    entry: str
    color: str
    start_s: float
    end_s: float
    is_in_view: bool


class Samples(NamedTuple):
    """A file of samples.

    colors: in the order of the file; ignores_unlabeled: pixels of a frame with regions that are in
    none of them are not used; else they are of no color. entries: the region or range of each
    entry, with the name of its recording, '' for all of them.
    """

    path: str
    colors: Tuple[str, ...]
    ignores_unlabeled: bool
    entries: Tuple[Tuple[str, Any], ...]

    def check_colors(self) -> None:
        """Raise SampleError for a color of which it is not said where it is."""
        for color in self.colors:
            if not any(sample.color == color and getattr(sample, 'is_in_view', True)
                       for _, sample in self.entries):
                raise SampleError('{}: there is no sample of {}'.format(self.path, color),
                                  'add a part of a frame, or a time in which it is in view')

    def check_recordings(self, recordings: Sequence[str]) -> None:
        """Raise SampleError for an entry whose recording is not among these, or is not one."""
        for name, sample in self.entries:
            count = sum(is_named(path, name) for path in recordings)
            if not count:
                raise SampleError('{}: {}: there is no recording {}{}'.format(
                    self.path, sample.entry, name, _similar(name, recordings)),
                    'give it as an argument, or correct the name')
            if count > 1 and (name or isinstance(sample, Region)):
                raise SampleError('{}: {}: {} recordings are meant by {!r}'.format(
                    self.path, sample.entry, count, name),
                    'set recording: to more of its path')


def is_named(path: str, name: str) -> bool:
    """Return whether a name means the recording at a path; an empty one means each.

    >>> is_named('/data/monday/drive.bag', 'monday/drive.bag')
    True
    >>> is_named('/data/monday/drive.bag', 'day/drive.bag')
    False
    """
    path = os.path.abspath(os.path.expanduser(path))
    return not name or ('/' + path.lstrip('/')).endswith('/' + os.path.normpath(name).lstrip('/'))


def _similar(name: str, recordings: Sequence[str]) -> str:
    hint = suggestion(name, [os.path.basename(path) for path in recordings])
    return hint and ', ' + hint.rstrip('?')
