"""The program sweep: closed loops by the thousand, and how many of them succeed.

Each is a loop of replay.py --camera robot, in simulated time and without a master.
"""
import argparse
import os
import re
import shlex
from typing import Sequence

from img_recog import files
from img_recog.batch import sweep_file, sweep_report, sweep_run
from img_recog.batch.engine import Engine, add_options
from img_recog.batch.sweep_file import Run, Sweep
from img_recog.batch.sweep_report import Ended
from img_recog.batch.work import Piece
from img_recog.command_line import programs, results
from img_recog.command_line.programs import allowed
from img_recog.errors import UserError, counted, suggestion
from img_recog.processes.signals import Interrupts

_FILE_ROLES = 'world', 'urdf', 'colors'


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
        worst = sweep_report.worst(ended, given.films)
        filmed = {piece.key: film for piece, film in engine.run(
            sweep_run.film, [_piece(sweep, each.run) for each in worst], ' films')}
        names = {each.run.key: name for each, name in zip(worst, films)}
        shown = [(each, engine.problems.get(each.run.key) or os.path.basename(
            names[each.run.key])) for each in worst]
        written = [*reports, *(names[key] for key in filmed)]
        with files.atomic_write(written) as opened:
            title = os.path.basename(path)
            results.write_report(
                opened[:len(reports)], sweep_report.table(ended), sweep_report.markdown(
                    title, sweep, ended, shown, 'rosrun img_recog sweep.py ' + shlex.quote(path)),
                lambda file: sweep_report.draw(file, title, sweep, ended))
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
    parser.add_argument('--output', default='', metavar='FOLDER_OR_PREFIX',
                        help='where to write the files (default: NAME.sweep.csv, .md, .png and '
                        '.worst_1.mp4 to .worst_10.mp4 in the current folder)')
    parser.add_argument('--films', default=10, metavar='N', help='of the worst runs '
                        '(default: %(default)s)',
                        type=allowed(int, lambda films: 0 <= films <= 100, 'from 0 to 100'))
    parser.add_argument('--only', default='', metavar='KEY',
                        help='run this run of the table alone, and write its film')
    add_options(parser)
    return parser
