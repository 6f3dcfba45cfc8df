"""The command lines of check_robot.py, check_world.py and simulate.py."""
import argparse
import sys
from typing import Callable

from img_recog.checks.report import Report
from img_recog.command_line.option_types import allowed
from img_recog.errors import UserError, one_line

_SECONDS = allowed(float, lambda seconds: 0 < seconds <= 1e6, 'a number above 0, at most 1e6')


def robot() -> int:
    """Check the robot that the command line names; return the exit code."""
    parser = _parser('check_robot.py', 'Say what of a robot is simulated, what is not, and what '
                     'is assumed; drive it a little.', 'a URDF or xacro file; with '
                     "arguments of xacro: 'FILE NAME:=VALUE ...'")
    parser.add_argument('--controllers', metavar='YAML', action='append', default=[],
                        help='parameters of its controllers of ros_control; may be repeated')
    options = parser.parse_args()
    from img_recog.checks import robot_check    # it takes a second, as does PyBullet
    return _run(parser.prog, lambda: robot_check.check(options.file, options.controllers))


def world() -> int:
    """Check the world that the command line names; return the exit code."""
    parser = _parser('check_world.py', 'Say what of a world is simulated, what is not, and what '
                     'is left out.', 'an SDF, URDF or xacro file, or what else `world` can be')
    parser.add_argument('--allow-partial-world', action='store_true',
                        help='exit with 0 also if something is left out')
    options = parser.parse_args()
    from img_recog.checks import world_check
    return _run(parser.prog,
                lambda: world_check.check(options.file, options.allow_partial_world))


def simulate() -> int:
    """Print where everything is in the simulation that the command line names."""
    parser = argparse.ArgumentParser(
        prog='simulate.py', allow_abbrev=False, description='Simulate a world as fast as it goes '
        'and print lines of JSON: where all links and joints are at each time, and at the end '
        'what the sensors measure, and the masses. It needs no master. Exits with 1 '
        'if the world or the robot cannot be used, with 2 if something of the world is left out.')
    parser.add_argument('world', metavar='WORLD',
                        help='an SDF, URDF or xacro file, or what else `world` can be')
    parser.add_argument('--urdf', metavar='ROBOT', default='',
                        help='a URDF or xacro file; the robot starts at x 0, y 0')
    parser.add_argument('--until', metavar='S', type=_SECONDS, default=2.0,
                        help='simulated time, in s (default: %(default)s)')
    parser.add_argument('--every', metavar='S', type=_SECONDS, default=0.1,
                        help='simulated time between two lines, in s (default: %(default)s)')
    parser.add_argument('--twist', metavar='V,W', default='',
                        help='the command of the robot, in m/s and rad/s')
    parser.add_argument('--drive', metavar='MODEL::JOINT=VELOCITY:TORQUE', action='append',
                        default=[], help='a motor, in rad/s and N m or m/s and N; may be repeated')
    parser.add_argument('--velocity', metavar='MODEL=VX,VY,VZ[,WX,WY,WZ]', action='append',
                        default=[], help='of a model at the start, in m/s and rad/s; may be '
                        'repeated')
    parser.add_argument('--pictures', metavar='DIR', default='',
                        help='write an image of each camera at the end')
    given = parser.parse_args()
    from img_recog.checks import simulation_run
    try:
        run = simulation_run.Run(simulation_run.Options(
            given.world, given.urdf, given.until, given.every, given.twist, given.drive,
            given.velocity, given.pictures))
        told = 0
        for line in run.lines():
            for warning in run.warnings[told:]:
                sys.stderr.write('warning: {}\n'.format(warning))
            told = len(run.warnings)
            sys.stdout.write(simulation_run.text_of(line) + '\n')
    except UserError as error:
        sys.stderr.write('{}: {}\n'.format(parser.prog, one_line(error)))
        return 1
    return 2 if run.left_out else 0


def _parser(prog: str, description: str, file: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=prog, description=description + ' It needs no master. Exits with 1 if it cannot be '
        'used.', allow_abbrev=False)
    parser.add_argument('file', metavar='FILE', help=file)
    return parser


def _run(prog: str, check: Callable[[], Report]) -> int:
    try:
        report = check()
    except UserError as error:
        sys.stderr.write('{}: {}\n'.format(prog, one_line(error)))
        return 1
    sys.stdout.write(report.text())
    if report.problem:
        sys.stderr.write('{}: {}\n'.format(prog, report.problem))
    return 1 if report.problem else 2 if report.is_partial else 0
