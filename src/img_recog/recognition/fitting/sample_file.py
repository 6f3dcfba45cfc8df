"""Reads a file of samples."""
import os
from typing import Any, Dict, Sequence, Tuple

from img_recog.errors import UserError, one_line, shortened, suggestion
from img_recog.files import plain
from img_recog.formats.markup import MarkupError, read_bytes
from img_recog.formats.yaml_text import load_yaml
from img_recog.recognition.fitting.samples import (IGNORED, NO_COLOR, Region, SampleError,
                                                   Samples, TimeRange, corners)
from img_recog.recognition.recognition_settings import SettingError, color_names

OTHER = 'other'
_MAX_BYTES, _MAX_NUMBER = 1 << 24, 1e9
_ADVICE = 'see the examples in doc/fitting.md'
_SHAPES = 'rectangle', 'polygon', 'mask'
_TIMES = 'in_view', 'not_in_view'
_TOP = 'colors', 'unlabeled', 'samples'
_FIELDS = ('recording', 'color', 'frame', *_SHAPES, *_TIMES)


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
        sample.color for _, sample in entries
        if sample.color not in (NO_COLOR, IGNORED)))
    samples = Samples(path, colors, unlabeled == IGNORED, entries)
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
            raise self._refused(name, '', value, 'lines like color: red and frame: 3')
        _check_names(self._path, name, value, _FIELDS)
        given = [field for field in (*_SHAPES, *_TIMES) if field in value]
        if len(given) != 1:
            raise self._error(name, 'got {}, expected one of {}'.format(
                ' and '.join(given) or 'none', ', '.join((*_SHAPES, *_TIMES))))
        recording = value.get('recording', '')
        if not isinstance(recording, str):
            raise self._refused(name, 'recording', recording, 'the name of a file')
        color, kind = self._color(name, value.get('color')), given[0]
        if kind in _TIMES:
            return recording, self._range(name, color, kind, value)
        frame = value.get('frame', 0)
        if not _is_number(frame, int) or frame < 0:
            raise self._refused(name, 'frame', frame, 'a whole number from 0')
        if kind == 'mask':
            return recording, Region(name, color, frame, (), self._mask(name, value[kind]))
        return recording, Region(name, color, frame,
                                 self._outline(name, kind, value[kind]), b'')

    def _color(self, name: str, color: Any) -> str:
        try:
            if color in (NO_COLOR, IGNORED):
                return str(color)
            color, = color_names([color])
        except SettingError:
            raise self._refused(name, 'color', color, 'the name of a color, {} or {}'.format(
                NO_COLOR, IGNORED))
        if self.colors and color not in self.colors:
            raise self._error(name, 'there is no color {}, the colors are {}'.format(
                shortened(color), ', '.join(self.colors)))
        return str(color)

    def _range(self, name: str, color: str, kind: str, value: Dict[str, Any]) -> TimeRange:
        times = value[kind]
        if color in (NO_COLOR, IGNORED):
            raise self._error(name, '{} needs a color'.format(kind))
        if not (isinstance(times, list) and len(times) == 2
                and all(_is_number(time, (int, float)) for time in times)
                and 0 <= times[0] < times[1]):
            raise self._refused(name, kind, times, '[start, end] in s, 0 or more')
        return TimeRange(name, color, float(times[0]), float(times[1]), kind == 'in_view')

    def _mask(self, name: str, mask: Any) -> bytes:
        if not isinstance(mask, str) or not mask.lower().endswith('.png'):
            raise self._refused(name, 'mask', mask, 'the path of a PNG')
        path = os.path.join(os.path.dirname(os.path.abspath(self._path)),
                            os.path.expanduser(mask))
        try:
            return read_bytes(path, opener=plain)
        except (OSError, UserError) as error:
            raise self._error(name, 'cannot read the mask {}: {}'.format(path, one_line(error)))

    def _outline(self, name: str, kind: str, value: Any) -> Tuple[Tuple[float, float], ...]:
        if kind == 'rectangle':
            if not (_are_numbers(value, 4) and value[2] > 0 and value[3] > 0):
                raise self._refused(name, kind, value, '[left, top, width, height] in pixels')
            return corners(*value)
        if not (isinstance(value, list) and len(value) >= 3
                and all(_are_numbers(corner, 2) for corner in value)):
            raise self._refused(name, kind, value, 'three or more corners [x, y] in pixels')
        return tuple((x, y) for x, y in value)

    def _refused(self, name: str, field: str, got: Any, expected: str) -> SampleError:
        return self._error(name, '{}got {}, expected {}'.format(
            field and field + ': ', shortened(repr(got)), expected))

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
    ranges = [(name, each) for name, each in samples.entries if isinstance(each, TimeRange)]
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


def _is_number(value: Any, kinds: Any) -> bool:
    return (isinstance(value, kinds) and not isinstance(value, bool)
            and abs(value) <= _MAX_NUMBER)


def _are_numbers(value: Any, count: int) -> bool:
    return (isinstance(value, list) and len(value) == count
            and all(_is_number(each, (int, float)) for each in value))
