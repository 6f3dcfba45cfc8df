"""Compare the final poses of many small worlds with Gazebo and with an earlier version.

FOLDER has a file cases.json and a folder cases with the worlds and robots. cases.json maps the
name of each case to a description:

    until     simulated time at the end, in s
    period    simulated time between two states, in s (unused)
    drive     motors: MODEL::JOINT=VELOCITY:TORQUE, separated by spaces
    vel       velocities of models at the start: MODEL=VX,VY,VZ[,WX,WY,WZ], separated by spaces
    urdf, twist_of_the_product
              a robot and its command in m/s and rad/s: one more run, which Gazebo does not have

The world of a case is cases/NAME.sdf. A case without a world has only the run of the robot.

The program prints for each case by how much our poses differ from Gazebo. Gazebo's poses are kept
in the file that --gazebo names. With --ask, the program runs the worlds that are missing there in
Gazebo. --write and --against show what a change of the simulator does to the poses.
"""
import argparse
import concurrent.futures
import json
import logging
import math
import os
import sys
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Sequence

from gazebo_runs import GazeboProgram, StoredResults, final_state, pose_difference, write_json

from img_recog.checks.check_jobs import simulate_parser
from img_recog.checks.simulation_run import SimulationRun
from img_recog.command_line import programs
from img_recog.errors import UserError, one_line

_CHANGED_M, _CHANGED_RAD = 0.001, 0.002
_EMPTY_WORLD = 'empty'
_ROBOT_RUN = ' robot'       # what the name of the run of a case's robot ends with
_DEFAULT_ROBOT_S = 3.0
# m: an angle counts as the way of a point at this distance from the axis
_LEVER_M = 0.5
_MAX_PROCESSES = 2


class Run(NamedTuple):
    """One simulation of a case.

    Attributes:
        name: Name of the case; the run of its robot has ' robot' after it.
        world: Path of an SDF file, or the name of a world.
        until_s: Simulated time at the end.
        drives: Motors, each as MODEL::JOINT=VELOCITY:TORQUE.
        velocities: Velocities of models at the start.
        urdf: Path of a robot; empty for none.
        twist: Command of the robot in m/s and rad/s.
    """

    name: str
    world: str
    until_s: float
    drives: Sequence[str] = ()
    velocities: Sequence[str] = ()
    urdf: str = ''
    twist: Sequence[float] = ()

    @property
    def is_in_gazebo(self) -> bool:
        """Whether Gazebo can run it."""
        return not self.urdf

    def words(self) -> List[str]:
        """Return the arguments of simulate.py."""
        return [self.world, '--until', repr(self.until_s), '--every', repr(self.until_s),
                *(word for drive in self.drives for word in ('--drive', drive)),
                *(word for velocity in self.velocities for word in ('--velocity', velocity)),
                *(('--urdf', self.urdf, '--twist={},{}'.format(*self.twist))
                  if self.urdf else ())]


class Change(NamedTuple):
    """A link whose pose is not what it was.

    Attributes:
        run: Name of the run.
        link: MODEL::LINK.
        moved_m: Distance between the two positions.
        turned_rad: Angle between the two orientations.
        verdict: 'nearer', 'farther' or 'as far', compared with Gazebo; '' without Gazebo.
    """

    run: str
    link: str
    moved_m: float
    turned_rad: float
    verdict: str


def read_runs(folder: str, names: Sequence[str] = ()) -> List[Run]:
    """Return the runs of the cases in a folder.

    Args:
        folder: Path of the folder.
        names: Names of the cases; none for all.

    Raises:
        UserError: if there is no such case.
    """
    with open(os.path.join(folder, 'cases.json')) as file:
        cases = json.load(file)
    unknown = sorted(set(names) - set(cases))
    if unknown:
        raise UserError('there is no case ' + ', '.join(unknown))
    return [run for name in names or cases
            for run in _runs_of(name, cases[name], os.path.join(folder, 'cases'))]


def _runs_of(name: str, case: Dict[str, Any], folder: str) -> Iterator[Run]:
    until_s, world = case.get('until'), os.path.join(folder, name + '.sdf')
    if until_s and os.path.exists(world):
        yield Run(name, world, float(until_s), case.get('drive', '').split(),
                  case.get('vel', '').split())
    if case.get('urdf'):
        yield Run(name + _ROBOT_RUN, _EMPTY_WORLD, float(until_s or _DEFAULT_ROBOT_S),
                  urdf=os.path.join(folder, case['urdf']), twist=case['twist_of_the_product'])


def simulate(run: Run) -> Dict[str, Any]:
    """Run a case in our simulator and return its final state.

    Args:
        run: The run.

    Returns:
        Times, links, joints and rays; or 'error' with the reason if it cannot be run.
    """
    logging.disable(logging.CRITICAL)
    folder = os.getcwd()
    try:
        if not run.urdf:        # a world names its files relative to its folder
            os.chdir(os.path.dirname(run.world))
        return _plain(final_state(list(SimulationRun(
            simulate_parser().parse_args(run.words())).lines())))
    except UserError as error:
        return {'error': one_line(error)}
    finally:
        os.chdir(folder)


def _plain(value: Any) -> Any:
    """Return a value in which numbers that JSON does not have are text."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value


def ask(runs: Sequence[Run], program: GazeboProgram, stored: StoredResults) -> None:
    """Run in Gazebo what is not stored yet.

    Args:
        runs: The runs.
        program: The program that runs Gazebo.
        stored: Results of Gazebo; gets new ones.
    """
    for run in runs:
        if not run.is_in_gazebo or run.name in stored.by_name:
            continue
        try:
            stored.store(run.name, final_state(program.run(
                run.world, run.until_s, run.until_s, run.drives, run.velocities)))
        except UserError as error:
            stored.store(run.name, {'error': one_line(error)})


def difference_line(name: str, ours: Dict[str, Any], gazebo: Optional[Dict[str, Any]]) -> str:
    """Return a line with the largest difference of a run.

    Args:
        name: Name of the run.
        ours: Our final state.
        gazebo: Gazebo's final state; None if there is none.

    >>> one = {'links': {'a::b': [0, 0, 0, 0, 0, 0, 1]}}
    >>> difference_line('fall', one, {'links': {'a::b': [0, 0, 2, 0, 0, 0, 1]}})
    'fall                              2.0000 m   0.0000 rad  a::b'
    >>> difference_line('fall', one, None)
    'fall                              not in Gazebo'
    """
    text = '{:<32}'.format(name)
    for which, state in (('img_recog', ours), ('Gazebo', gazebo)):
        if state and 'error' in state:
            return '{}  {}: {}'.format(text, which, state['error'][:90])
    if gazebo is None:
        return text + '  not in Gazebo'
    both = sorted(set(ours['links']) & set(gazebo['links']))
    only = {'img_recog': sorted(set(ours['links']) - set(gazebo['links'])),
            'Gazebo': sorted(set(gazebo['links']) - set(ours['links']))}
    found = {link: pose_difference(ours['links'][link], gazebo['links'][link]) for link in both}
    notes = ''.join('; only in {}: {}'.format(which, ', '.join(links[:3]) + (
        ' and {} more'.format(len(links) - 3) if len(links) > 3 else ''))
        for which, links in only.items() if links)
    if not found:
        return '{}  no link in both{}'.format(text, notes)
    worst = max(found, key=lambda link: _size(found[link]))
    distance_m, angle_rad = found[worst]
    return '{}  {:.4f} m  {:7.4f} rad  {}{}'.format(text, distance_m, angle_rad, worst, notes)


def changes(before: Dict[str, Any], after: Dict[str, Any],
            gazebo: Dict[str, Any]) -> List[Change]:
    """Return the links whose poses have changed.

    Args:
        before: Final states of an earlier version, by the name of the run.
        after: Final states of now.
        gazebo: Final states in Gazebo.
    """
    return [change for name in sorted(set(before) & set(after))
            for change in _changes(name, *(states.get(name, {}).get('links', {})
                                           for states in (before, after, gazebo)))]


def _changes(name: str, before: Dict[str, Any], after: Dict[str, Any],
             gazebo: Dict[str, Any]) -> Iterator[Change]:
    for link in sorted(set(before) & set(after)):
        moved = pose_difference(before[link], after[link])
        if moved[0] > _CHANGED_M or moved[1] > _CHANGED_RAD:
            yield Change(name, link, *moved, _verdict(
                *(_size(pose_difference(pose, gazebo[link])) for pose in (
                    before[link], after[link]))) if link in gazebo else '')


def _verdict(before_m: float, after_m: float) -> str:
    if abs(after_m - before_m) <= _CHANGED_M:
        return 'as far'
    return 'nearer' if after_m < before_m else 'farther'


def _size(difference: Sequence[float]) -> float:
    distance_m, angle_rad = difference
    return distance_m + _LEVER_M * angle_rad


def change_lines(before: Dict[str, Any], after: Dict[str, Any],
                 gazebo: Dict[str, Any]) -> Iterator[str]:
    """Yield lines about what has changed; arguments as for `changes`."""
    for name in sorted(set(after) & set(before)):
        errors = [states[name].get('error', '') for states in (before, after)]
        if errors[0] != errors[1]:
            yield '{}: error before: {}; error now: {}'.format(name, *(
                error or 'none' for error in errors))
        missing = [sorted(set(states[0]) - set(states[1])) for states in (
            (before[name].get('links', {}), after[name].get('links', {})),
            (after[name].get('links', {}), before[name].get('links', {})))]
        for what, links in zip(('missing now', 'new'), missing):
            if links and errors[0] == errors[1]:
                yield '{}: {}: {}'.format(name, what, ', '.join(links))
    found = changes(before, after, gazebo)
    for each in found:
        yield '{:<32}  {:<40} moved {:.4f} m, turned {:.4f} rad  {}'.format(
            each.run, each.link, each.moved_m, each.turned_rad, each.verdict)
    counts = ', '.join('{} {}'.format(sum(each.verdict == verdict for each in found), name)
                       for verdict, name in (('nearer', 'nearer to Gazebo'), (
                           'farther', 'farther'), ('as far', 'as far'), ('', 'not in Gazebo')))
    yield '{} links have changed in {} runs: {}'.format(
        len(found), len({each.run for each in found}), counts)


def _parser() -> argparse.ArgumentParser:
    parser = programs.parser(
        'compare_cases.py', __doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', metavar='FOLDER', help='folder with cases.json and cases/')
    parser.add_argument('--cases', nargs='+', metavar='NAME', default=[],
                        help='names of cases (default: all)')
    parser.add_argument('--gazebo', metavar='FILE', default='',
                        help='JSON file with the poses in Gazebo')
    parser.add_argument('--ask', metavar='PROGRAM', default='',
                        help='program that runs a world in Gazebo with the arguments of '
                        'simulate.py; results go into the file of --gazebo')
    parser.add_argument('--port', metavar='PORT', default='',
                        help="port of Gazebo's master, for PROGRAM")
    parser.add_argument('--write', metavar='FILE', default='',
                        help='write our final poses, joints and rays to the last digit')
    parser.add_argument('--against', metavar='FILE', default='',
                        help='list the links that differ from an earlier file of --write by more '
                        'than {} m or {} rad'.format(_CHANGED_M, _CHANGED_RAD))
    parser.add_argument('--processes', metavar='N', type=int, default=_MAX_PROCESSES,
                        help='number of simulations at a time (default: %(default)s)')
    return parser


def _compare(words: List[str], _: Any) -> str:
    given = _parser().parse_args(words)
    if given.ask and not given.gazebo:
        raise UserError('--ask needs a file for the results', 'set --gazebo FILE')
    runs = read_runs(os.path.abspath(given.folder), given.cases)
    gazebo: Dict[str, Any] = {}
    if given.gazebo:
        stored = StoredResults(given.gazebo)
        gazebo = stored.by_name
        if given.ask:
            ask(runs, GazeboProgram(os.path.abspath(given.ask), given.port), stored)
    with concurrent.futures.ProcessPoolExecutor(given.processes) as pool:
        ours = {}
        for run, state in zip(runs, pool.map(simulate, runs)):
            ours[run.name] = state
            programs.write(difference_line(run.name, state, gazebo.get(run.name)))
    if given.write:
        write_json(given.write, ours)
    if given.against:
        with open(given.against) as file:
            before = json.load(file)
        programs.write('')
        for line in change_lines(before, ours, gazebo):
            programs.write(line)
    return ''


if __name__ == '__main__':
    sys.exit(programs.run('compare_cases.py', _compare))
