"""A file of samples: where in recordings a color is, and when it is in view."""
import os
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple

from img_recog.errors import UserError, one_line, shortened, suggestion
from img_recog.markup import MarkupError, load_yaml, read_bytes
from img_recog.recognition.settings import SettingError, color_names

NO_COLOR = 'none'
OTHER, IGNORED = 'other', 'ignored'
_MAX_BYTES, _MAX_NUMBER = 1 << 24, 1e9
_ADVICE = 'see the examples in doc/fitting.md'
_SHAPES = 'rectangle', 'polygon', 'mask'
_TIMES = 'in_view', 'not_in_view'
_TOP = 'colors', 'unlabeled', 'samples'
_FIELDS = ('recording', 'color', 'frame', *_SHAPES, *_TIMES)


class SampleError(UserError):
    """A file of samples, or an entry of it, cannot be used; names the file and the entry."""


class Region(NamedTuple):
    """A part of a frame that has a color, or none of the colors (NO_COLOR).

    entry: as messages name it; frame: number of the frame, from 0.
    outline: corners (x, y) in pixels of a rectangle or polygon, whose edges belong to it; mask:
    path of a PNG, in which pixels that are not black belong to it. One of both is given.
    """

    entry: str
    color: str
    frame: int
    outline: Tuple[Tuple[float, float], ...]
    mask: str


class Range(NamedTuple):
    """A range of time in which a color is in view or not, in s from the first frame."""

    entry: str
    color: str
    start_s: float
    end_s: float
    is_in_view: bool


class RecordingSamples(NamedTuple):
    """The samples of one recording."""

    regions: Tuple[Region, ...]
    ranges: Tuple[Range, ...]

    @property
    def last_frame(self) -> int:
        """The number of the last frame with a region, -1 if there is none."""
        return max((region.frame for region in self.regions), default=-1)


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

    def of(self, recording: str) -> RecordingSamples:
        """Return the samples of the recording at this path."""
        chosen = [sample for name, sample in self.entries if is_named(recording, name)]
        return RecordingSamples(
            tuple(each for each in chosen if isinstance(each, Region)),
            tuple(each for each in chosen if isinstance(each, Range)))

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


def read(path: str) -> Samples:
    """Return the samples in a YAML file.

    Raises SampleError naming the file, the entry, what was got and what is allowed.
    """
    try:
        values = load_yaml(read_bytes(path, _MAX_BYTES))
    except (OSError, MarkupError) as error:
        raise SampleError('cannot read the samples in {}: {}'.format(path, one_line(error)),
                          _ADVICE)
    if not isinstance(values, dict) or not isinstance(values.get('samples'), list):
        raise SampleError('{}: expected a list samples: of entries'.format(path), _ADVICE)
    _check_names(path, '', values, _TOP)
    if not values['samples']:
        raise SampleError('{}: there is no sample'.format(path), _ADVICE)
    unlabeled = values.get('unlabeled', OTHER)
    if unlabeled not in (OTHER, IGNORED):
        raise SampleError('{}: unlabeled: got {}, allowed is {} or {}'.format(
            path, shortened(repr(unlabeled)), OTHER, IGNORED))
    reader = _Reader(path, _colors(path, values))
    entries = tuple(reader.entry(number, value)
                    for number, value in enumerate(values['samples'], 1))
    colors = reader.colors or tuple(dict.fromkeys(
        sample.color for _, sample in entries if sample.color != NO_COLOR))
    samples = Samples(path, colors, unlabeled == IGNORED, entries)
    for color in colors:
        if not any(sample.color == color and getattr(sample, 'is_in_view', True)
                   for _, sample in entries):
            raise SampleError('{}: there is no sample of {}'.format(path, color),
                              'add a part of a frame, or a time in which it is in view')
    _check_times(samples)
    return samples


def _colors(path: str, values: Dict[str, Any]) -> Tuple[str, ...]:
    """Return the parameter `colors`; without it, the entries decide which there are."""
    if 'colors' not in values:
        return ()
    try:
        return color_names(values['colors'])
    except SettingError as error:
        raise SampleError('{}: colors: got {}, allowed is {}'.format(
            path, error.got, error.allowed))


class _Reader:
    """Reads the entries of a file; colors: the allowed ones, empty for any."""

    def __init__(self, path: str, colors: Tuple[str, ...]):
        self._path, self.colors = path, colors

    def entry(self, number: int, value: Any) -> Tuple[str, Any]:
        """Return the name of the recording of entry `number`, and its region or range."""
        name = 'entry {}'.format(number)
        if not isinstance(value, dict):
            raise self._error(name, 'got {}, expected lines like color: red and frame: 3'.format(
                shortened(repr(value))))
        _check_names(self._path, name, value, _FIELDS)
        given = [field for field in (*_SHAPES, *_TIMES) if field in value]
        if len(given) != 1:
            raise self._error(name, 'got {}, expected one of {}'.format(
                ' and '.join(given) or 'none', ', '.join((*_SHAPES, *_TIMES))))
        recording = value.get('recording', '')
        if not isinstance(recording, str):
            raise self._error(name, 'recording: got {}, expected the name of a file'.format(
                shortened(repr(recording))))
        color, kind = self._color(name, value.get('color')), given[0]
        if kind in _TIMES:
            return recording, self._range(name, color, kind, value)
        frame = value.get('frame', 0)
        if not _is_number(frame, int) or frame < 0:
            raise self._error(name, 'frame: got {}, expected a whole number from 0'.format(
                shortened(repr(frame))))
        if kind == 'mask':
            return recording, Region(name, color, frame, (), self._mask(name, value[kind]))
        return recording, Region(name, color, frame,
                                 self._outline(name, kind, value[kind]), '')

    def _color(self, name: str, color: Any) -> str:
        try:
            if color == NO_COLOR:
                return NO_COLOR
            color, = color_names([color])
        except SettingError:
            raise self._error(name, 'color: got {}, expected the name of a color, or {}'.format(
                shortened(repr(color)), NO_COLOR))
        if self.colors and color not in self.colors:
            raise self._error(name, 'there is no color {}, the colors are {}'.format(
                shortened(color), ', '.join(self.colors)))
        return str(color)

    def _range(self, name: str, color: str, kind: str, value: Dict[str, Any]) -> Range:
        times = value[kind]
        if color == NO_COLOR:
            raise self._error(name, '{} needs a color'.format(kind))
        if not (isinstance(times, list) and len(times) == 2
                and all(_is_number(time, (int, float)) for time in times)
                and 0 <= times[0] < times[1]):
            raise self._error(name, '{}: got {}, expected [start, end] in s, 0 or more'.format(
                kind, shortened(repr(times))))
        return Range(name, color, float(times[0]), float(times[1]), kind == 'in_view')

    def _mask(self, name: str, mask: Any) -> str:
        if not isinstance(mask, str) or not mask.lower().endswith('.png'):
            raise self._error(name, 'mask: got {}, expected the path of a PNG'.format(
                shortened(repr(mask))))
        path = os.path.join(os.path.dirname(os.path.abspath(self._path)),
                            os.path.expanduser(mask))
        if not os.path.isfile(path):
            raise self._error(name, 'mask: there is no file {}'.format(path))
        return path

    def _outline(self, name: str, kind: str, value: Any) -> Tuple[Tuple[float, float], ...]:
        if kind == 'rectangle':
            if not (_are_numbers(value, 4) and value[2] > 0 and value[3] > 0):
                raise self._error(name, 'rectangle: got {}, expected [left, top, width, height] '
                                  'in pixels'.format(shortened(repr(value))))
            left, top, width, height = value
            right, bottom = left + width - 1, top + height - 1
            return (left, top), (right, top), (right, bottom), (left, bottom)
        if not (isinstance(value, list) and len(value) >= 3
                and all(_are_numbers(corner, 2) for corner in value)):
            raise self._error(name, 'polygon: got {}, expected three or more corners [x, y] in '
                              'pixels'.format(shortened(repr(value))))
        return tuple((x, y) for x, y in value)

    def _error(self, name: str, problem: str) -> SampleError:
        return SampleError('{}: {}: {}'.format(self._path, name, problem))


def _check_names(path: str, entry: str, values: Dict[Any, Any], known: Sequence[str]) -> None:
    for name in values:
        if name not in known:
            hint = suggestion(str(name), known) or 'known are {}'.format(', '.join(known))
            raise SampleError('{}: {}there is no {}'.format(
                path, entry and entry + ': ', shortened(name)), hint)


def _check_times(samples: Samples) -> None:
    """Raise SampleError if a color is in view and not in view at the same time."""
    ranges = [(name, each) for name, each in samples.entries if isinstance(each, Range)]
    for name, seen in ranges:
        for other, unseen in ranges:
            if (seen.color != unseen.color or not seen.is_in_view or unseen.is_in_view
                    or name and other and name != other):
                continue
            common_s = min(seen.end_s, unseen.end_s) - max(seen.start_s, unseen.start_s)
            if common_s > 0:
                raise SampleError(
                    '{}: {} and {} contradict each other: {} is in view and not in view in '
                    '{:.3g} s, {:.0%} of {}'.format(
                        samples.path, seen.entry, unseen.entry, seen.color, common_s,
                        common_s / (seen.end_s - seen.start_s), seen.entry), 'correct one')


def _similar(name: str, recordings: Sequence[str]) -> str:
    hint = suggestion(name, [os.path.basename(path) for path in recordings])
    return hint and ', ' + hint.rstrip('?')


def _is_number(value: Any, kinds: Any) -> bool:
    return (isinstance(value, kinds) and not isinstance(value, bool)
            and abs(value) <= _MAX_NUMBER)


def _are_numbers(value: Any, count: int) -> bool:
    return (isinstance(value, list) and len(value) == count
            and all(_is_number(each, (int, float)) for each in value))
