#!/usr/bin/env python3
"""Start a program of another package that opens a window, or say how to install it.

roslaunch ends with an error for a node whose package is missing; the demo goes on without a window
that is not needed.
"""
import argparse
import os
import subprocess
import sys

from img_recog.command_line import programs


def main():
    """Replace this process by the program; return the exit code if that cannot be."""
    parser = programs.parser('optional_window.py', __doc__)
    parser.add_argument('package', metavar='PACKAGE')
    parser.add_argument('program', metavar='PROGRAM')
    parser.add_argument('arguments', metavar='ARGUMENT', nargs=argparse.REMAINDER)
    given = parser.parse_args()
    package, arguments = given.package, given.arguments
    name = next((word.partition(':=')[2] for word in arguments if word.startswith('__name:=')),
                given.program)
    found = subprocess.run(['rospack', 'find', package], stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, check=False).returncode == 0
    if not found:
        return _skip(name, '{} is not installed: install the package {} (Debian, if it has it) or '
                     'ros-noetic-{}'.format(package, package.replace('_', '-'),
                                            package.replace('_', '-')))
    if not os.environ.get('DISPLAY'):
        return _skip(name, 'there is no display: set DISPLAY, or look at the page (web:=true)')
    os.execvp('rosrun', ['rosrun', package, given.program, *arguments])


def _skip(name, reason):
    sys.stderr.write('[{}] no window: {}\n'.format(name, reason))
    return 0


if __name__ == '__main__':
    sys.exit(main())
