"""Compare how public robots drive here and in Gazebo, with the same velocities of the wheels.

FOLDER has a clone of each repository of test/public_robots.yaml, at the commit there, in
OWNER+NAME. Each robot gets three commands at four headings, for 3 simulated seconds. Its values
are the distance between the start and the end in the plane, and the yaw. A value agrees if it
differs from Gazebo's by at most 10 %, or by at most 2 cm or 0.03 rad if that is more.

Gazebo's values are in test/public_robots_in_gazebo.json, so the comparison needs no Gazebo. With
--ask and --convert, the program runs the robots in Gazebo and writes that file again. The worlds
are in FOLDER/worlds/NAME then, with their meshes.
"""
import argparse
import concurrent.futures
import json
import logging
import os
import subprocess
import sys
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence

import public_robots
from gazebo_runs import GazeboProgram, StoredResults, write_json
from public_robots import COMMANDS, HEADINGS, Robot

from img_recog.command_line import programs
from img_recog.errors import UserError

IN_GAZEBO = os.path.join(public_robots.ROOT, 'test', 'public_robots_in_gazebo.json')
_RELATIVE, _DISTANCE_M, _YAW_RAD = 0.1, 0.02, 0.03
# a ratio of smaller yaws has no meaning
_TURNS_RAD = 0.1
_STAYS_M = 0.02
_MAX_PROCESSES = 2


class Comparison(NamedTuple):
    """A command at a heading, in Gazebo and here.

    Attributes:
        robot: Name of the robot.
        command: Name of the command.
        heading: Yaw at the start in rad.
        gazebo: Distance in m and yaw in rad in Gazebo.
        ours: Distance and yaw here.
    """

    robot: str
    command: str
    heading: float
    gazebo: Sequence[float]
    ours: Sequence[float]

    @property
    def agreements(self) -> List[bool]:
        """Whether the distance and the yaw agree."""
        return [agrees(*each) for each in zip(self.ours, self.gazebo, (_DISTANCE_M, _YAW_RAD))]

    @property
    def yaw_ratio(self) -> float:
        """Our yaw divided by Gazebo's; 1 if the robot does not turn in Gazebo."""
        return self.ours[1] / self.gazebo[1] if abs(self.gazebo[1]) >= _TURNS_RAD else 1.0

    @property
    def turns_wrongly(self) -> bool:
        """Whether the robot turns by less than half or by more than twice of Gazebo's yaw."""
        return not 0.5 <= self.yaw_ratio <= 2.0

    @property
    def strays(self) -> bool:
        """Whether a pure turn moves the robot here, but not in Gazebo."""
        return COMMANDS[self.command][0] == 0 and self.gazebo[0] <= _STAYS_M < self.ours[0]


def agrees(ours: float, gazebo: float, tolerance: float) -> bool:
    """Return whether our value agrees with Gazebo's.

    Args:
        ours: Our value.
        gazebo: Gazebo's value.
        tolerance: Difference that is always allowed.

    >>> agrees(1.1, 1.0, 0.02), agrees(1.11, 1.0, 0.02), agrees(0.0, 0.019, 0.02)
    (True, False, True)
    """
    return abs(ours - gazebo) <= max(_RELATIVE * abs(gazebo), tolerance) + 1e-9


def compare(robot: str, gazebo: Dict[str, Any], ours: Dict[str, Any]) -> List[Comparison]:
    """Return the comparisons of a robot.

    Args:
        robot: Name of the robot.
        gazebo: Values in Gazebo: by command, for each heading.
        ours: Our values.
    """
    return [Comparison(robot, command, heading, *pair)
            for command in ours for heading, *pair in zip(
                HEADINGS, gazebo[command], ours[command])]


def share(comparisons: Sequence[Comparison]) -> float:
    """Return the share of the values that agree, from 0 to 1.

    Args:
        comparisons: At least one comparison.
    """
    agreements = [each for one in comparisons for each in one.agreements]
    return sum(agreements) / len(agreements)


def worst_yaw_ratio(comparisons: Sequence[Comparison]) -> float:
    """Return the ratio of yaws that differs from 1 by the largest factor.

    Args:
        comparisons: At least one comparison.
    """
    return max((each.yaw_ratio for each in comparisons),
               key=lambda ratio: max(ratio, 1 / ratio) if ratio > 0 else float('inf'))


def table(comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield the lines of a table of one robot; a value that does not agree has a star.

    Args:
        comparisons: Comparisons of the robot, at least one.
    """
    yield '{}: {:.0%} of the values agree'.format(comparisons[0].robot, share(comparisons))
    yield '  {:<10}{:>8}   {:>8}{:>11}   {:>8}{:>11}'.format(
        'command', 'heading', 'Gazebo', 'img_recog', 'Gazebo', 'img_recog')
    yield '  {:<10}{:>8}   {:>19}   {:>19}'.format('', 'rad', 'distance, m', 'yaw, rad')
    for each in comparisons:
        marks = [' ' if good else '*' for good in each.agreements]
        yield '  {:<10}{:>8g}   {:>8.3f}{:>10.3f}{}   {:>8.3f}{:>10.3f}{}'.format(
            each.command, each.heading, each.gazebo[0], each.ours[0], marks[0],
            each.gazebo[1], each.ours[1], marks[1]).rstrip()


def summary(comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield lines about all robots.

    Args:
        comparisons: Comparisons of all robots, at least one.
    """
    for title, found in (
            ('turn by less than half or more than twice of the yaw in Gazebo',
             [each for each in comparisons if each.turns_wrongly]),
            ('pure turns that move the robot by more than 2 cm only here',
             [each for each in comparisons if each.strays])):
        yield '{}: {}'.format(title, len(found) or 'none')
        for each in found:
            yield ('  {}, {} at {:g} rad: yaw {:.3f} rad, in Gazebo {:.3f} rad; distance {:.3f} '
                   'm, in Gazebo {:.3f} m').format(
                       each.robot, each.command, each.heading, each.ours[1], each.gazebo[1],
                       each.ours[0], each.gazebo[0])
    yield '{:.0%} of all {} values agree'.format(share(comparisons), 2 * len(comparisons))


def markdown(comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield the lines of a table for the documentation, with a row for each robot.

    Args:
        comparisons: Comparisons of all robots, at least one.
    """
    yield '| Robot | Values that agree | Yaw here / yaw in Gazebo, worst |'
    yield '| --- | --- | --- |'
    for name in dict.fromkeys(each.robot for each in comparisons):
        rows = [each for each in comparisons if each.robot == name]
        yield '| {} | {:.0%} | {:.2f} |'.format(name, share(rows), worst_yaw_ratio(rows))
    yield '| all | {:.0%} | {:.2f} |'.format(share(comparisons), worst_yaw_ratio(comparisons))


def _ask(robots: Sequence[Robot], given: argparse.Namespace) -> None:
    stored = StoredResults(IN_GAZEBO)
    program = GazeboProgram(os.path.abspath(given.ask), given.port)
    for robot in robots:
        worlds = json.loads(_in_process_of(robot, given.folder, [
            '--convert', given.convert, '--write-worlds']))
        stored.store(robot.name, public_robots.run_in_gazebo(robot, worlds, program))


def _in_process_of(robot: Robot, folder: str, options: Sequence[str]) -> str:
    """Run this program for one robot, in a process that finds its packages."""
    return subprocess.run(
        [sys.executable, os.path.abspath(__file__), os.path.abspath(folder), *options,
         '--robots', robot.name],
        env=public_robots.environment(robot, os.path.abspath(folder)), stdout=subprocess.PIPE,
        universal_newlines=True, check=True).stdout.splitlines()[-1]


def _parser() -> argparse.ArgumentParser:
    parser = programs.parser(
        'compare_robots.py', __doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', metavar='FOLDER', help='folder of clones')
    parser.add_argument('--robots', nargs='+', metavar='NAME', default=[],
                        help='names of robots (default: all)')
    parser.add_argument('--commands', nargs='+', metavar='COMMAND', choices=list(COMMANDS),
                        default=list(COMMANDS), help='names of commands: {} (default: all)'.format(
                            ', '.join(COMMANDS)))
    parser.add_argument('--markdown', action='store_true',
                        help='print only a table for the documentation')
    parser.add_argument('--write', metavar='FILE', default='', help='write our values as JSON')
    parser.add_argument('--processes', metavar='N', type=int, default=_MAX_PROCESSES,
                        help='number of robots at a time (default: %(default)s)')
    parser.add_argument('--ask', metavar='PROGRAM', default='',
                        help='program that runs a world in Gazebo with the arguments of '
                        'simulate.py')
    parser.add_argument('--convert', metavar='COMMAND', default='gz sdf -p /dev/stdin',
                        help='command that reads a URDF and prints the SDF that Gazebo makes of '
                        'it (default: %(default)s)')
    parser.add_argument('--port', metavar='PORT', default='',
                        help="port of Gazebo's master, for PROGRAM")
    # for the processes that this program starts
    parser.add_argument('--write-worlds', action='store_true', help=argparse.SUPPRESS)
    parser.add_argument('--simulate', action='store_true', help=argparse.SUPPRESS)
    return parser


def _compare(words: List[str], _: Any) -> str:
    given = _parser().parse_args(words)
    robots = public_robots.read_list(given.robots)
    if given.write_worlds or given.simulate:
        logging.disable(logging.CRITICAL)
        robot, folder = robots[0], given.folder
        return json.dumps(public_robots.write_worlds(robot, folder, given.convert)
                          if given.write_worlds
                          else public_robots.simulate(robot, folder, given.commands))
    if given.ask:
        _ask(robots, given)
    in_gazebo = StoredResults(IN_GAZEBO).by_name
    missing = [robot.name for robot in robots if robot.name not in in_gazebo]
    if missing:
        raise UserError('there are no values of Gazebo for ' + ', '.join(missing),
                        'set --ask and --convert')
    ours: Dict[str, Any] = {}
    comparisons: List[Comparison] = []
    with concurrent.futures.ThreadPoolExecutor(given.processes) as pool:
        options = ['--simulate', '--commands', *given.commands]
        for robot, text in zip(robots, pool.map(
                lambda robot: _in_process_of(robot, given.folder, options), robots)):
            ours[robot.name] = json.loads(text)
            found = compare(robot.name, in_gazebo[robot.name], ours[robot.name])
            comparisons += found
            for line in () if given.markdown else (*table(found), ''):
                programs.write(line)
    if given.write:
        write_json(given.write, ours)
    for line in (markdown if given.markdown else summary)(comparisons):
        programs.write(line)
    return ''


if __name__ == '__main__':
    sys.exit(programs.run('compare_robots.py', _compare))
