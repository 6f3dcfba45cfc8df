"""The program evaluate: what several sets of colors make of recordings, side by side."""
import argparse
import csv
import functools
import logging
import os
from typing import Callable, Dict, List, Sequence

from img_recog import files
from img_recog.batch import evaluate_report, recorded
from img_recog.batch.engine import Engine, add_options
from img_recog.batch.evaluate_report import ColorSet, Measured, Truth, evaluated
from img_recog.batch.work import Piece
from img_recog.command_line import programs, results
from img_recog.errors import UserError, counted, one_line, shortened, suggestion
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recordings import recording_names
from img_recog.recordings.frames import Remarks

_TRUTH = 'recording', 'frame', 'color', 'in_view'
_log = logging.getLogger('evaluate.py')


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
                opened, evaluate_report.table(sets, found),
                evaluate_report.markdown(
                    sets, found, truth, recorded.not_used(engine.problems, said)),
                lambda file: evaluate_report.draw(file, sets, found))
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
    for piece, measured in engine.run(evaluate_report.measure, [
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
    parser.add_argument('--output', default='', metavar='FOLDER_OR_PREFIX',
                        help='where to write the files (default: NAME.evaluated.csv, .md and .png '
                        'in the current folder, of the first recording)')
    add_options(parser)
    return parser
