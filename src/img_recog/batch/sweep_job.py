"""The program sweep: closed loops by the thousand, and how many of them succeed.

Each is a loop of replay.py --camera robot, in simulated time and without a master.
"""
import argparse
import math
import os
import re
import shlex
from typing import IO, Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog import files
from img_recog.batch import sweep_file, sweep_run
from img_recog.batch.engine import Engine, add_options
from img_recog.batch.sweep_file import Range, Run, Sweep, Values
from img_recog.batch.sweep_run import COLLISION, PATH, REACHED, TIME, Result
from img_recog.batch.work import Piece
from img_recog.command_line import programs, results
from img_recog.command_line.programs import allowed
from img_recog.errors import UserError, counted, suggestion
from img_recog.processes.signals import Interrupts
from img_recog.recordings import recording_names

_SIZE_IN = 5.0          # of each chart
_BINS, _MAX_RANGES = 6, 3
_MAX_PROBLEMS = 20
_Z = 1.959964           # of 95 %, two-sided
_NOT_RUN = 'not run'
_REASONS = REACHED, COLLISION, PATH, TIME, _NOT_RUN
_FILE_ROLES = 'world', 'urdf', 'colors'


class Ended(NamedTuple):
    """A run and its result, or in one line why there is none."""

    run: Run
    result: Optional[Result]
    problem: str = ''

    @property
    def reason(self) -> str:
        return self.result.reason if self.result else _NOT_RUN

    @property
    def is_success(self) -> bool:
        return self.reason == REACHED


def table(ended: Sequence[Ended]) -> results.Table:
    """Return the table: a row for each run."""
    parameters = sorted({name for each in ended for name in each.run.parameters})
    columns = ['key', *(ended[0].run.labels if ended else ()),
               *(name for name in parameters if name not in ended[0].run.labels), 'seed',
               'success', *Result._fields, 'problem']
    return results.Table(columns, [{
        **_rounded(each.run.parameters), 'key': each.run.key, **each.run.labels,
        'seed': each.run.seed, 'success': int(each.is_success),
        **_rounded(each.result._asdict() if each.result else {}),
        'problem': each.problem} for each in ended])


def _rounded(values: Values) -> Values:
    return {name: round(value, 6) if isinstance(value, float) else value
            for name, value in values.items()}


def worst_runs(ended: Sequence[Ended], count: int) -> List[Ended]:
    """Return the runs that have failed and ended farthest from the goal, then the longest ones."""
    ran = [(each.is_success, -each.result.time_s if each.is_success else -each.result.distance_m,
            each.run.key, each) for each in ended if each.result]
    return [each for *_, each in sorted(ran, key=lambda row: row[:3])[:count]]


def markdown(title: str, sweep: Sweep, ended: Sequence[Ended],
             films: Sequence[Tuple[Ended, str]], command: str) -> str:
    """Return the report. films: the worst runs, and the names of their films.

    command: how the sweep was started, without its options.
    """
    lines = ['# ' + title, '', '{}, of which {} have succeeded: {}.'.format(
        counted(len(ended), 'run'), sum(each.is_success for each in ended), _rate(ended))]
    rows, columns = _cells(sweep)
    lines += results.markdown_part(
        'Success rate, with its 95 % confidence interval (Wilson):',
        [' / '.join(sweep.cells), *columns],
        [[row, *(_rate(_in(sweep, ended, row, column)) for column in columns)] for row in rows])
    lines += results.markdown_part(
        'How the runs have ended:', [*sweep.cells[:1], *_REASONS],
        [[row, *(str(sum(each.reason == reason for each in ended
                         if each.run.labels[sweep.cells[0]] == row)) for reason in _REASONS)]
         for row in rows])
    lines += results.markdown_part(
        'The worst runs:', ['run', 'ended by', 'distance', 'time', 'film', 'again'],
        [[each.run.key, each.reason, '{:.2f} m'.format(each.result.distance_m),
          '{:.1f} s'.format(each.result.time_s), name,
          '`{} --only {}`'.format(command, shlex.quote(each.run.key))]
         for each, name in films if each.result])
    failed = [each for each in ended if each.problem]
    if failed:
        lines += ['', 'Without a result: {}'.format(counted(len(failed), 'run')), '']
        lines += ['- {}: {}'.format(each.run.key, each.problem)
                  for each in failed[:_MAX_PROBLEMS]]
    return '\n'.join(lines) + '\n'


def _rate(ended: Sequence[Ended]) -> str:
    successes = sum(each.is_success for each in ended)
    low, high = wilson(successes, len(ended))
    return '{:.0f} % ({:.0f} to {:.0f})'.format(
        100 * successes / max(1, len(ended)), 100 * low, 100 * high)


def _cells(sweep: Sweep) -> Tuple[List[str], List[str]]:
    """Return the labels of the rows, and of the columns, of the table of rates."""
    labels = {choice.name: list(choice.groups) for choice in sweep.choices}
    if not sweep.cells:
        return [], []
    return labels[sweep.cells[0]], labels[sweep.cells[1]] if len(sweep.cells) > 1 else ['all']


def _in(sweep: Sweep, ended: Sequence[Ended], row: str, column: str) -> List[Ended]:
    wanted = dict(zip(sweep.cells, (row, column)))
    return [each for each in ended
            if all(each.run.labels[name] == label for name, label in wanted.items())]


def draw(file: IO[bytes], title: str, sweep: Sweep, ended: Sequence[Ended]) -> None:
    """Write the picture, a PNG: the rates of the cells, and by what each run has drawn."""
    drawn = [name for name in sorted({name for each in ended for name in each.run.parameters})
             if any(isinstance(values.get(name), Range) for values in (
                 sweep.fixed, *(group for choice in sweep.choices
                                for group in choice.groups.values())))][:_MAX_RANGES]
    charts = bool(sweep.cells) + len(drawn)
    with results.picture(file, (_SIZE_IN * max(1, charts), _SIZE_IN)) as figure:
        figure.suptitle(title)
        axes = [figure.add_subplot(1, max(1, charts), number + 1) for number in range(charts)]
        if sweep.cells:
            _draw_cells(axes[0], sweep, ended)
        for chart, name in zip(axes[bool(sweep.cells):], drawn):
            _draw_rates(chart, name, ended)
        figure.tight_layout()


def _draw_cells(axes: Any, sweep: Sweep, ended: Sequence[Ended]) -> None:
    rows, columns = _cells(sweep)
    rates = np.array([[_share(_in(sweep, ended, row, column)) for column in columns]
                      for row in rows])
    axes.imshow(rates, cmap='RdYlGn', vmin=0, vmax=1, aspect='auto')
    for y, row in enumerate(rows):
        for x, column in enumerate(columns):
            axes.text(x, y, _rate(_in(sweep, ended, row, column)).replace(' (', '\n('),
                      ha='center', va='center')
    axes.set_xticks(range(len(columns)))     # labels in the same call need matplotlib 3.5
    axes.set_xticklabels(columns, rotation=20)
    axes.set_yticks(range(len(rows)))
    axes.set_yticklabels(rows)
    axes.set_title('Success rate: {}'.format(' / '.join(sweep.cells)))


def _draw_rates(axes: Any, name: str, ended: Sequence[Ended]) -> None:
    pairs = [(each.run.parameters[name], each) for each in ended if name in each.run.parameters]
    values = np.array([value for value, _ in pairs], float)
    edges = np.linspace(values.min(), values.max(), _BINS + 1)
    bins = np.clip(np.searchsorted(edges, values, 'right') - 1, 0, _BINS - 1)
    for number in range(_BINS):
        found = [each for (_, each), where in zip(pairs, bins) if where == number]
        if found:
            low, high = wilson(sum(each.is_success for each in found), len(found))
            middle = (edges[number] + edges[number + 1]) / 2
            axes.plot([middle, middle], [low, high], color='#9467bd')
            axes.plot([middle], [_share(found)], 'o', color='#9467bd')
    axes.set_ylim(0, 1)
    axes.set_title('Success rate by ' + name)
    axes.set_xlabel(name)


def _share(ended: Sequence[Ended]) -> float:
    return sum(each.is_success for each in ended) / max(1, len(ended))


def wilson(successes: int, runs: int) -> Tuple[float, float]:
    """Return the 95 % confidence interval of a rate of success (Wilson 1927).

    >>> [round(end, 3) for end in wilson(9, 10)]
    [0.596, 0.982]
    >>> wilson(0, 0)
    (0.0, 1.0)
    """
    if not runs:
        return 0.0, 1.0
    rate, square = successes / runs, _Z ** 2 / runs
    middle = rate + square / 2
    margin = _Z * math.sqrt(rate * (1 - rate) / runs + square / (4 * runs))
    return (max(0.0, (middle - margin) / (1 + square)), min(1.0, (middle + margin) / (1 + square)))


def main() -> int:
    """Run the program; return its exit code, 1 if a run has no result."""
    return programs.run('sweep.py', _main, 'cannot write')


def _main(words: Sequence[str], interrupts: Interrupts) -> str:
    given = _parser().parse_args(words)
    path = os.path.expanduser(given.sweep)
    sweep = sweep_file.read(path)
    if given.only:
        return _only(sweep, given, path)
    ends = ['.worst_{}.mp4'.format(number + 1) for number in range(given.films)]
    paths = files.output_paths(path, os.path.expanduser(given.output),
                               (*results.report_extensions(), *ends), 'sweep')
    reports, films = paths[:len(paths) - len(ends)], paths[len(paths) - len(ends):]
    runs = list(sweep.runs())
    with Engine(given, interrupts, paths[0][:-len('.csv')]) as engine:
        found = {piece.key: result for piece, result in engine.run(
            sweep_run.run, [_piece(sweep, run) for run in runs])}
        ended = [Ended(run, found.get(run.key), engine.problems.get(run.key, ''))
                 for run in runs]
        worst = worst_runs(ended, given.films)
        filmed = {piece.key: film for piece, film in engine.run(
            sweep_run.film, [_piece(sweep, each.run) for each in worst], ' films')}
        names = {each.run.key: name for each, name in zip(worst, films)}
        shown = [(each, engine.problems.get(each.run.key) or os.path.basename(
            names[each.run.key])) for each in worst]
        written = [*reports, *(names[key] for key in filmed)]
        with files.atomic_write(written) as opened:
            title = os.path.basename(path)
            results.write_report(
                opened[:len(reports)], table(ended), markdown(
                    title, sweep, ended, shown, 'rosrun img_recog sweep.py ' + shlex.quote(path)),
                lambda file: draw(file, title, sweep, ended))
            for file, film in zip(opened[len(reports):], filmed.values()):
                file.write(film)
    failed = sum(bool(each.problem) for each in ended)
    summary = '{}, {} have succeeded, {} have no result; wrote {}'.format(
        counted(len(ended), 'run'), sum(each.is_success for each in ended), failed,
        ', '.join(written))
    return programs.Incomplete(summary) if failed else summary


def _only(sweep: Sweep, given: argparse.Namespace, path: str) -> str:
    """Run one run again, and write its film."""
    runs = {run.key: run for run in sweep.runs()}
    if given.only not in runs:
        raise UserError('--only: there is no run {}'.format(given.only),
                        suggestion(given.only, runs))
    name = '.{}.mp4'.format(re.sub(r'[^\w.=-]+', '_', given.only))
    film, = files.output_paths(path, os.path.expanduser(given.output), [name], 'sweep')
    piece = _piece(sweep, runs[given.only])
    result = sweep_run.run(piece.files, *piece.arguments)
    with files.atomic_write([film]) as (file,):
        file.write(sweep_run.film(piece.files, *piece.arguments))
    return ('{}: {} after {:.3f} s, {:.3f} m from the goal, {} collisions, path {:.3f} m; wrote {}'
            .format(given.only, *result[:5], film))


def _piece(sweep: Sweep, run: Run) -> Piece:
    """Return the piece of a run: of its values, whatever their labels are."""
    values = run.parameters
    depends, read = sweep_run.inputs(*sweep_run.scene_of(values))
    roles = tuple(role for role in _FILE_ROLES if os.path.isabs(values.get(role) or ''))
    return Piece(run.key, (roles, Run('', {}, run.seed, values), sweep.success,
                           sweep.settings.time_limit), tuple(values[role] for role in roles),
                 depends=depends, read=read)


def _parser() -> argparse.ArgumentParser:
    parser = programs.parser(
        'sweep.py', 'Run many closed loops of a camera on the simulated robot, '
        'with other worlds, starts, colors, cameras and robots, in simulated time and without a '
        'master; write how many succeed as a table (CSV), a report and a picture, and the worst '
        'ones as films.')
    parser.add_argument('sweep', metavar='SWEEP.yaml', help='which runs, and what is a success')
    recording_names.add_output(parser, 'NAME.sweep.csv, .md, .png, .worst_1.mp4 to .worst_10.mp4')
    parser.add_argument('--films', default=10, metavar='N', help='of the worst runs '
                        '(default: %(default)s)',
                        type=allowed(int, lambda films: 0 <= films <= 100, 'from 0 to 100'))
    parser.add_argument('--only', default='', metavar='KEY',
                        help='run this run of the table alone, and write its film')
    add_options(parser)
    return parser
