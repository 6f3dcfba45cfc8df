"""The program evaluate: what several sets of colors make of recordings, side by side."""
import argparse
import csv
import functools
import logging
import math
import os
from typing import IO, Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog import files
from img_recog.batch import recorded
from img_recog.batch.engine import Engine, add_options
from img_recog.batch.work import Piece
from img_recog.command_line import programs, results
from img_recog.errors import UserError, counted, one_line, shortened, suggestion
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command, Commander
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import parts, recording_names
from img_recog.recordings.frames import SECOND_NS, Part, Remarks

# whether a color is in view: by recording; by number of the frame, and color
Truth = Dict[str, Dict[Tuple[int, str], bool]]

_WIDTH_IN, _ROW_IN = 12.0, 2.5
_MAX_ROWS = 12              # recordings in the picture
_MAX_SPANS = 10             # of frames in which sets of colors differ, in the report
_TRUTH = 'recording', 'frame', 'color', 'in_view'
_log = logging.getLogger('evaluate.py')


class Measured(NamedTuple):
    """What was measured in the frames of a part, in their order.

    numbers, stamps_ns: of the frames; areas_px: of each set of colors, (frames, colors);
    remarks: on what could not be used.
    """

    numbers: List[int]
    stamps_ns: List[int]
    areas_px: List[np.ndarray]
    remarks: Remarks


class ColorSet(NamedTuple):
    """A file with colors; name: in the output."""

    name: str
    path: str
    settings: RecognitionSettings


class Evaluated(NamedTuple):
    """A recording, and what each set of colors does in it.

    numbers, times_s: of the frames, from the first one; areas_px: as in Measured; commands: of
    each set, for each frame the last one that is published for it, which holds, or None.
    """

    name: str
    numbers: List[int]
    times_s: List[float]
    areas_px: List[np.ndarray]
    commands: List[List[Optional[Command]]]


def measure(paths: Sequence[str], part: Part, max_pixels: int) -> Measured:
    """Return the areas in a part of a recording; for the engine.

    paths: of the recording and of the sets of colors. Each frame is decoded once.
    """
    settings = [parameter_file.read(path) for path in paths[1:]]
    extractors = [ColorExtractor(each) for each in settings]
    areas_px: List[List[List[int]]] = [[] for _ in extractors]
    found: List[Tuple[int, int]] = []
    frames = parts.read(paths[0], part, max_pixels)
    for frame in frames.read():
        found.append((frame.number, frame.stamp_ns))
        for areas, extractor in zip(areas_px, extractors):
            areas.append(extractor.measure(frame.image, frame.encoding))
    return Measured([number for number, _ in found], [stamp_ns for _, stamp_ns in found], [
        np.array(areas, np.int32).reshape(len(areas), len(each.colors))
        for areas, each in zip(areas_px, settings)], frames.remarks)


def evaluated(name: str, measured: Sequence[Measured], sets: Sequence[ColorSet]) -> Evaluated:
    """Return what sets of colors do in a recording; measured: of its parts, by these sets."""
    stamps_ns = [stamp_ns for part in measured for stamp_ns in part.stamps_ns]
    times_s = [(stamp_ns - stamps_ns[0]) / SECOND_NS for stamp_ns in stamps_ns]
    areas_px = [np.concatenate(each) for each in zip(*(part.areas_px for part in measured))]
    commands: List[List[Optional[Command]]] = []
    for colors, areas in zip(sets, areas_px):
        commander = Commander(colors.settings, 0.0)
        published = map(commander.decide, areas.tolist(), times_s)
        commands.append([each[-1] if each else None for each in published])
    return Evaluated(name, [number for part in measured for number in part.numbers], times_s,
                     areas_px, commands)


def table(sets: Sequence[ColorSet], found: Sequence[Evaluated]) -> results.Table:
    """Return the table: a row for each frame and set of colors."""
    areas = list(dict.fromkeys(color.name + '_px' for each in sets
                               for color in each.settings.colors))
    columns = ['recording', 'colors', 'frame', 'time_s', *areas, 'linear_x_m_per_s',
               'angular_z_rad_per_s']

    def rows() -> Iterator[Dict[str, Any]]:
        for each in found:
            for colors, commands, areas_px in zip(sets, each.commands, each.areas_px):
                names = [color.name + '_px' for color in colors.settings.colors]
                for frame, time_s, areas, command in zip(
                        each.numbers, each.times_s, areas_px.tolist(), commands):
                    yield {'recording': each.name, 'colors': colors.name, 'frame': frame,
                           'time_s': time_s, **dict(zip(names, areas)),
                           **dict(zip(columns[-2:], command or ()))}
    return results.Table(columns, rows())


def markdown(sets: Sequence[ColorSet], found: Sequence[Evaluated], truth: Truth,
             unused: Sequence[str]) -> str:
    """Return the report; unused: lines on what could not be used."""
    lines = ['# Recordings under {}'.format(counted(len(sets), 'set of colors'))]
    lines += results.markdown_part(
        'How many frames are above the limit of a color, and have a command:',
        ['recording', 'colors', 'frames', 'above the limit', 'with a command'],
        [[each.name, colors.name, str(len(each.numbers)),
          ', '.join('{} {:.1f} %'.format(color.name, 100 * np.mean(areas > color.area_limit_px))
                    for color, areas in zip(colors.settings.colors, areas_px.T)),
          '{:.1f} %'.format(100 * sum(each is not None for each in commands) / len(commands))]
         for each in found
         for colors, areas_px, commands in zip(sets, each.areas_px, each.commands)])
    if truth:
        lines += results.markdown_part(
            'Found in the frames of the truth:',
            ['colors', 'color', 'precision', 'recall', 'frames'], _scores(sets, found, truth))
    spans = sorted(_spans(sets, found), key=lambda span: (-span[3], span[:3]))
    lines += results.markdown_part(
        'Where other colors than {} command something else, the longest first:'.format(
            sets[0].name),
        ['recording', 'colors', 'from', 'frames'],
        [[name, colors, '{:.2f} s'.format(begin_s), str(count)]
         for name, colors, begin_s, count in spans[:_MAX_SPANS]])
    if found and len(sets) > 1 and not spans:
        lines += ['', 'All sets of colors command the same in all frames.']
    return '\n'.join([*lines, *unused]) + '\n'


def _scores(sets: Sequence[ColorSet], found: Sequence[Evaluated], truth: Truth
            ) -> Iterator[List[str]]:
    """Yield how each color is found; frames that `truth` says nothing about do not count."""
    for number, colors in enumerate(sets):
        for index, color in enumerate(colors.settings.colors):
            pairs = [(bool(area_px > color.area_limit_px), truth[each.name][frame, color.name])
                     for each in found
                     for frame, area_px in zip(each.numbers, each.areas_px[number][:, index])
                     if (frame, color.name) in truth.get(each.name, {})]
            score = Score(*map(pairs.count, ((True, True), (True, False), (False, True))))
            yield [colors.name, color.name, *score.shares, str(len(pairs))]


def _spans(sets: Sequence[ColorSet], found: Sequence[Evaluated]
           ) -> Iterator[Tuple[str, str, float, int]]:
    """Yield where commands differ from those of the first set: from when, in s; frames."""
    for each in found:
        for colors, commands in zip(sets[1:], each.commands[1:]):
            differs = [mine != other for mine, other in zip(commands, each.commands[0])]
            edges = np.flatnonzero(np.diff([False, *differs, False]))
            for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist()):
                yield each.name, colors.name, each.times_s[begin], end - begin


def draw(file: IO[bytes], sets: Sequence[ColorSet], found: Sequence[Evaluated]) -> None:
    """Write the picture, a PNG: the command of each set over time."""
    shown = list(found[:_MAX_ROWS])
    count = max(1, len(shown))
    with results.picture(file, (_WIDTH_IN, _ROW_IN * count + 0.5)) as figure:
        rows = figure.subplots(count, 1, squeeze=False)[:, 0]
        for axes, each in zip(rows, shown):
            for colors, commands in zip(sets, each.commands):
                axes.step(each.times_s, [math.nan if command is None else command.linear_x
                                         for command in commands], where='post',
                          label=colors.name)
            axes.set_title(each.name)
            axes.set_ylabel('linear.x (m/s)')
        rows[-1].set_xlabel('time (s)')
        if shown:
            rows[0].legend()
        figure.tight_layout()


def main() -> int:
    """Run the program; return its exit code, 1 if a recording cannot be used."""
    return programs.run('evaluate.py', _main, 'cannot write')


def _main(words: Sequence[str], interrupts: Interrupts) -> str:
    given = _parser().parse_args(words)
    named = _named([os.path.abspath(path) for path in recording_names.expand(
        given.recordings, _log.warning)], recorded.of_path)
    paths = files.output_paths(next(iter(named.values())), os.path.expanduser(given.output),
                               results.report_extensions(), 'evaluated')
    with Engine(given, interrupts, paths[0][:-len('.csv')], _log) as engine:
        engine.watch(map(_absolute, given.colors))
        sets = _color_sets(given.colors)
        truth = _read_truth(os.path.expanduser(given.truth), named, sets) if given.truth else {}
        measured = _measured(engine, named, sets, given)
        remarks = {name: [part.remarks for part in parts] for name, parts in measured.items()}
        said = recorded.said(remarks, _log)
        found = [evaluated(name, each, sets) for name, each in measured.items()]
        with files.atomic_write(paths) as opened:
            results.write_report(
                opened, table(sets, found),
                markdown(
                    sets, found, truth, recorded.not_used(engine.problems, said)),
                lambda file: draw(file, sets, found))
    used, skipped, *_ = functools.reduce(Remarks.plus, sum(remarks.values(), []), Remarks())
    summary = '{} of {}, {}, {}; wrote {}'.format(
        len(found), counted(len(named), 'recording'),
        ('{} of '.format(used) if skipped else '') + counted(used + skipped, 'frame'),
        counted(len(sets), 'set of colors'), ', '.join(paths))
    return programs.Incomplete(summary) if engine.problems else summary


def _measured(engine: Engine, named: Dict[str, str], sets: Sequence[ColorSet],
              given: argparse.Namespace) -> Dict[str, List[Measured]]:
    """Return what was measured in the parts of each recording that can be read to its end."""
    found: Dict[str, List[Measured]] = {}
    for piece, measured in engine.run(measure, [
            Piece(each.name, (each.part, given.max_image_pixels),
                  (each.path, *(colors.path for colors in sets)), each.part.frames)
            for each in recorded.divided(engine, named, given)], ' frames'):
        found.setdefault(piece.key, []).append(measured)
    return found


def _named(paths: Sequence[str], forms: Callable[[str], List[str]]) -> Dict[str, str]:
    """Return paths, each once, by short names that differ."""
    paths = list(dict.fromkeys(paths))
    return dict(zip(recorded.unique(list(map(forms, paths))), paths))


def _absolute(path: str) -> str:
    return os.path.abspath(os.path.expanduser(path))


def _color_sets(paths: Sequence[str]) -> List[ColorSet]:
    named = _named(list(map(_absolute, paths)), recorded.of_value)
    return [ColorSet(name, path, parameter_file.read(path)) for name, path in named.items()]


def _read_truth(path: str, named: Dict[str, str], sets: Sequence[ColorSet]) -> Truth:
    """Return what a table says is in view; raise UserError if it is not about what is given."""
    truth: Truth = {}
    colors = sorted({color.name for each in sets for color in each.settings.colors})
    try:
        with open(path, newline='', encoding='utf-8-sig') as file:     # Excel writes a BOM
            rows = csv.DictReader(file)
            missing = [name for name in _TRUTH if name not in (rows.fieldnames or ())]
            if missing:
                raise UserError('--truth {}: it has no column {}'.format(path, missing[0]),
                                'give one with the columns ' + ', '.join(_TRUTH))
            for row in rows:
                place = '--truth {}, line {}: '.format(path, rows.line_num)
                recording, frame, color, in_view = map(row.__getitem__, _TRUTH)
                for column, value, known in (('recording', recording, list(named)),
                                             ('color', color, colors)):
                    if value not in known:
                        raise UserError('{}there is no {} {}'.format(
                            place, column, shortened(value)),
                            suggestion(value, known) or 'there are ' + ', '.join(known))
                if in_view not in ('0', '1') or not frame.isdigit():
                    raise UserError(
                        place + 'expected a number as frame, and 0 or 1 as in_view')
                is_in_view = truth.setdefault(recording, {}).setdefault(
                    (int(frame), color), in_view == '1')
                if is_in_view != (in_view == '1'):
                    raise UserError('{}a line before it says the opposite of frame {} and {}'
                                    .format(place, frame, color), 'remove one of both')
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise UserError('--truth: cannot read {}: {}'.format(path, one_line(error)))
    return truth


def _parser() -> argparse.ArgumentParser:
    parser = programs.parser(
        'evaluate.py', 'Measure recordings with several sets of colors; write '
        'areas and commands side by side as a table (CSV), a report and a picture.')
    recording_names.add_to(parser)
    parser.add_argument('--colors', required=True, nargs='+', metavar='YAML',
                        help='parameter files of color_extract')
    parser.add_argument('--truth', default='', metavar='CSV',
                        help='which colors are in view: columns recording, frame, color, in_view')
    recording_names.add_output(parser, 'FIRST_RECORDING.evaluated.csv, .md and .png')
    add_options(parser)
    return parser
