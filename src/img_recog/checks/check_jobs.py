"""The command lines of check_robot.py, check_world.py, simulate.py and robot_description.py."""
import argparse
import math
import sys
from typing import Any, Callable, List, Sequence, Tuple

from img_recog.command_line import programs
from img_recog.command_line.programs import allowed
from img_recog.errors import UserError

_SECONDS = allowed(float, lambda seconds: 0 < seconds <= 1e6, 'a number above 0, at most 1e6')
_NO_MASTER = (' It needs no master. Exits with 1 if it cannot be used, with 2 if something that '
              'the file asks for is not done.')


class _Partial(programs.Incomplete):
    code = 2


def _check_robot(words: List[str], _: object) -> str:
    parser = programs.parser('check_robot.py', 'Say what of a robot is simulated, what is not, '
                             'and what is assumed; drive it a little.' + _NO_MASTER)
    parser.add_argument('file', metavar='FILE', help='a URDF or xacro file; with arguments of '
                        "xacro: 'FILE NAME:=VALUE ...'")
    parser.add_argument('--controllers', metavar='YAML', action='append', default=[],
                        help='parameters of its controllers of ros_control; may be repeated')
    options = parser.parse_args(words)
    from img_recog.checks import robot_check    # it takes a second, as does PyBullet
    return _text(robot_check.check(options.file, options.controllers))


def _check_world(words: List[str], _: object) -> str:
    parser = programs.parser('check_world.py', 'Say what of a world is simulated, what is not, '
                             'and what is left out.' + _NO_MASTER)
    parser.add_argument('file', metavar='FILE',
                        help='an SDF, URDF or xacro file, or what else `world` can be')
    parser.add_argument('--allow-partial-world', action='store_true',
                        help='do not exit with 1 if something is left out')
    options = parser.parse_args(words)
    from img_recog.checks import world_check
    return _text(world_check.check(options.file, options.allow_partial_world))


def _text(report: Any) -> str:
    """Return the text of a CheckReport; one with a problem is printed, and its problem raised."""
    text = report.text()[:-1]
    if report.problem:
        programs.write(text)
        raise UserError(report.problem)
    return _Partial(text) if report.is_partial else text


def _describe(words: List[str], _: object) -> str:
    parser = programs.parser('robot_description.py', 'Print the URDF of the file of a robot.')
    parser.add_argument('file', metavar='FILE', help='a URDF, or a xacro file, which is '
                        "expanded; with arguments: 'FILE NAME:=VALUE ...'")
    given = parser.parse_args(words)
    programs.keep_for_data()
    from img_recog.loading import robot_file
    return robot_file.read(given.file)


def simulate_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line of simulate.py."""
    parser = programs.parser(
        'simulate.py', 'Simulate a world as fast as it goes and print lines of JSON: where all '
        'links and joints are at each time, and at the end what the sensors measure, and the '
        'masses.' + _NO_MASTER)
    parser.add_argument('world', metavar='WORLD',
                        help='an SDF, URDF or xacro file, or what else `world` can be')
    parser.add_argument('--urdf', metavar='ROBOT', default='',
                        help='a URDF or xacro file; the robot starts at x 0, y 0')
    parser.add_argument('--until', metavar='S', type=_SECONDS, default=2.0,
                        help='simulated time, in s (default: %(default)s)')
    parser.add_argument('--every', metavar='S', type=_SECONDS, default=0.1,
                        help='simulated time between two lines, in s (default: %(default)s)')
    parser.add_argument('--twist', metavar='V,W',
                        type=allowed(lambda text: _numbers(text, ','), lambda found: len(
                            found) == 2, 'V,W: two numbers, m/s and rad/s'),
                        help='the command of the robot, in m/s and rad/s')
    parser.add_argument('--drive', metavar='MODEL::JOINT=VELOCITY:TORQUE', action='append',
                        default=[], type=_named(':', (2,), 'MODEL::JOINT=VELOCITY:TORQUE'),
                        help='a motor, in rad/s and N m or m/s and N; may be repeated')
    parser.add_argument('--velocity', metavar='MODEL=VX,VY,VZ[,WX,WY,WZ]', action='append',
                        default=[], type=_named(',', (3, 6), 'MODEL=VX,VY,VZ[,WX,WY,WZ]'),
                        help='of a model at the start, in m/s and rad/s; may be repeated')
    parser.add_argument('--pictures', metavar='DIR', default='',
                        help='write an image of each camera at the end')
    return parser


def _numbers(text: str, separator: str) -> List[float]:
    numbers = [float(number) for number in text.split(separator)]
    if not all(map(math.isfinite, numbers)):
        raise ValueError
    return numbers


def _named(separator: str, counts: Sequence[int], expected: str) -> Callable[[str], Any]:
    """Return the type of 'NAME=NUMBERS': a name and one of these counts of numbers."""
    def read(text: str) -> Tuple[str, List[float]]:
        name, _, numbers = text.rpartition('=')
        return name, _numbers(numbers, separator)
    return allowed(read, lambda found: len(found[1]) in counts, expected)


def _simulate(words: List[str], _: object) -> str:
    given = simulate_parser().parse_args(words)
    programs.keep_for_data()
    from img_recog.checks import simulation_run
    run = simulation_run.SimulationRun(given)
    for warning in run.report.lines():
        _warn(warning)
    run.report.listen(_warn)
    for line in run.lines():
        programs.write(simulation_run.text_of(line))
    return _Partial() if run.report.is_partial else ''


def _warn(line: str) -> None:
    sys.stderr.write('warning: {}\n'.format(line))


_PROGRAMS = {'check_robot.py': _check_robot, 'check_world.py': _check_world,
             'robot_description.py': _describe, 'simulate.py': _simulate}


def main(program: str) -> int:
    """Run one of these programs; return its exit code."""
    return programs.run(program, _PROGRAMS[program])
