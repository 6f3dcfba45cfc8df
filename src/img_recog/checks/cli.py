"""The command lines of check_robot.py and check_world.py."""
import argparse
import sys
from typing import Callable

from img_recog.checks.report import Report
from img_recog.errors import UserError, one_line


def robot() -> int:
    """Check the robot that the command line names; return the exit code."""
    parser = _parser('check_robot.py', 'Say what of a robot is simulated, what is not, and what '
                     'is assumed; drive it a little.', 'a URDF or xacro file')
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
    return 1 if report.problem else 0
