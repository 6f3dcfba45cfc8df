"""The program evaluate: what several sets of colors make of recordings, side by side."""
import argparse
import contextlib
import csv
import functools
import logging
import os
import re
from typing import Any, Callable, Dict, List, Sequence

from img_recog import files, resources
from img_recog.batch import evaluate_report, evaluation, inputs, labels, options, tables
from img_recog.batch.engine import Engine
from img_recog.batch.evaluation import ColorSet, Evaluated, Measured, Truth
from img_recog.batch.work import Function, Piece
from img_recog.errors import UserError, one_line, shortened, suggestion
from img_recog.recognition import parameter_file
from img_recog.recordings import names
from img_recog.recordings.frames import Remarks
from img_recog.replay import cli, programs
from img_recog.signals import Interrupts
from img_recog.simulation.settings import SpawnSettings

_TRUTH = 'recording', 'frame', 'color', 'in_view'
_log = logging.getLogger('evaluate.py')


def main() -> int:
    """Run the program; return its exit code, 1 if a recording cannot be used."""
    problems: List[str] = []
    code = programs.run('evaluate.py', lambda words, interrupts: _main(
        words, interrupts, problems), 'cannot write')
    return code or int(bool(problems))


def _main(words: Sequence[str], interrupts: Interrupts, problems: List[str]) -> str:
    given = _parser().parse_args(words)
    where = options.of(given)
    named = _named([os.path.abspath(path) for path in names.expand(
        given.recordings, _log.warning)], labels.of_path)
    sets = _color_sets(given.colors)
    truth = _read_truth(os.path.expanduser(given.truth), named, sets) if given.truth else {}
    paths = files.output_paths(next(iter(named.values())), os.path.expanduser(given.output),
                               (*tables.extensions(), '.md', '.png'), 'evaluated')
    work = re.sub(r'\.csv$', '', paths[0])
    with Engine(where, interrupts) as engine, contextlib.ExitStack() as stack:
        stages = _Stages(stack, work, engine, problems)
        measured = _measured(stages, named, sets, given.topic, given.max_image_pixels)
        found = _driven(stages, measured, sets, cli.world_name(given.world) if given.world else '')
        with files.atomic_write(paths) as opened:
            count = len(tables.extensions())
            tables.write(opened[:count], *evaluate_report.table(sets, found))
            report, picture = opened[count:]
            report.write(evaluate_report.markdown(
                sets, found, truth, problems + stages.remarks).encode())
            evaluate_report.draw(picture, sets, found)
    used, skipped, *_ = functools.reduce(Remarks.plus, (each.measured.remarks for each in found),
                                         Remarks())
    return '{} of {} recordings, {} frames, {} sets of colors; wrote {}'.format(
        len(found), len(named), '{} of {}'.format(used, used + skipped) if skipped else used,
        len(sets), ', '.join(paths))


class _Stages:
    """Runs pieces one stage after the other; their results stay until all is written.

    problems: a line for each recording that cannot be used; remarks: on the others.
    """

    def __init__(self, stack: contextlib.ExitStack, work: str, engine: Engine,
                 problems: List[str]):
        self._stack, self._work, self._engine, self._problems = stack, work, engine, problems
        self.remarks: List[str] = []

    def run(self, function: Function, pieces: Sequence[Piece], unit: str) -> Dict[str, List[Any]]:
        """Return the results by recording, whose name is in the key of a piece before the #."""
        found: Dict[str, List[Any]] = {}
        bad: List[str] = []
        for outcome in self._stack.enter_context(self._engine.outcomes(
                function, pieces, '{}.{}.work'.format(self._work, unit.strip()), unit)):
            name = outcome.key.rpartition('#')[0]
            found.setdefault(name, []).append(outcome.value)
            if outcome.problem and name not in bad:
                bad.append(name)
                self._problems.append('{}: {}'.format(name, outcome.problem))
                _log.error('%s', self._problems[-1])
        return {name: values for name, values in found.items() if name not in bad}


def _measured(stages: _Stages, named: Dict[str, str], sets: Sequence[ColorSet], topic: str,
              max_pixels: int) -> Dict[str, Measured]:
    """Return what was measured in each recording that can be read to its end, and has images."""
    parts = stages.run(evaluation.divide, [
        Piece(name + '#', (topic, max_pixels), (path,)) for name, path in named.items()],
        ' recordings')
    measured = stages.run(evaluation.measure, [
        Piece('{}#{}'.format(name, number), (part, max_pixels),
              (named[name], *(each.path for each in sets)), part.frames)
        for name, (divided,) in parts.items() for number, part in enumerate(divided)], ' frames')
    joined = {name: found[0].joined(found[1:]) for name, found in measured.items()}
    stages.remarks = ['{}: {}'.format(name, line) for name, each in joined.items()
                      for line in each.remarks.lines(named[name])]
    for line in stages.remarks:
        _log.warning('%s', line)
    return joined


def _driven(stages: _Stages, measured: Dict[str, Measured], sets: Sequence[ColorSet],
            world: str) -> List[Evaluated]:
    scene = inputs.of_scene(world, resources.burger()) if world else ''
    driven = stages.run(evaluation.drive, [
        Piece('{}#{}'.format(name, number), (each, number, world, SpawnSettings()),
              (colors.path, *([world] if os.path.isabs(world) else [])), depends=scene)
        for name, each in measured.items() for number, colors in enumerate(sets)], ' drives')
    return [Evaluated(name, measured[name], found) for name, found in driven.items()]


def _named(paths: Sequence[str], forms: Callable[[str], List[str]]) -> Dict[str, str]:
    """Return paths, each once, by short names that differ."""
    paths = list(dict.fromkeys(paths))
    return dict(zip(labels.unique(list(map(forms, paths))), paths))


def _color_sets(paths: Sequence[str]) -> List[ColorSet]:
    named = _named([os.path.abspath(os.path.expanduser(path)) for path in paths], labels.of_value)
    return [ColorSet(name, path, parameter_file.read(path)) for name, path in named.items()]


def _read_truth(path: str, named: Dict[str, str], sets: Sequence[ColorSet]) -> Truth:
    """Return what a table says is in view; raise UserError if it is not about what is given."""
    truth: Truth = {}
    colors = sorted({color.name for each in sets for color in each.settings.colors})
    try:
        with open(path, newline='') as file:
            rows = csv.DictReader(file)
            missing = [name for name in _TRUTH if name not in (rows.fieldnames or ())]
            if missing:
                raise UserError('--truth {}: it has no column {}'.format(path, missing[0]),
                                'give one with the columns ' + ', '.join(_TRUTH))
            for row in rows:
                for column, known in (('recording', list(named)), ('color', colors)):
                    if row[column] not in known:
                        raise UserError('--truth {}, line {}: there is no {} {}'.format(
                            path, rows.line_num, column, shortened(row[column])),
                            suggestion(row[column], known) or 'there are ' + ', '.join(known))
                if row['in_view'] not in ('0', '1') or not row['frame'].isdigit():
                    raise UserError('--truth {}, line {}: expected a number as frame, and 0 or 1 '
                                    'as in_view'.format(path, rows.line_num))
                truth.setdefault(row['recording'], {})[int(row['frame']), row['color']] = (
                    row['in_view'] == '1')
    except (OSError, csv.Error, UnicodeDecodeError) as error:
        raise UserError('--truth: cannot read {}: {}'.format(path, one_line(error)))
    return truth


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='evaluate.py', description='Measure recordings with several sets of colors; write '
        'areas, commands and the path of the simulated robot side by side as a table (CSV), a '
        'report and a picture.', allow_abbrev=False)
    names.add_to(parser)
    parser.add_argument('--colors', required=True, nargs='+', metavar='YAML',
                        help='parameter files of color_extract')
    parser.add_argument('--truth', default='', metavar='CSV',
                        help='which colors are in view: columns recording, frame, color, in_view')
    parser.add_argument('--world', default='',
                        help='also simulate the robot, in this world as for replay.py')
    parser.add_argument('--output', default='', metavar='FOLDER_OR_PREFIX',
                        help='where to write the files (default: NAME.evaluated.csv, .md and .png '
                        'in the current folder, of the first recording)')
    options.add_to(parser)
    return parser
