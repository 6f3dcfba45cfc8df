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
from img_recog.processes import display


def main():
    """Replace this process by the program; return the exit code if that cannot be."""
    parser = programs.parser('optional_window.py', __doc__)
    parser.add_argument('package', metavar='PACKAGE')
    parser.add_argument('program', metavar='PROGRAM')
    parser.add_argument('arguments', metavar='ARGUMENT', nargs=argparse.REMAINDER)
    given = parser.parse_args()
    name = next((word.partition(':=')[2] for word in given.arguments
                 if word.startswith('__name:=')), given.program)
    if subprocess.call(['rospack', 'find', given.package], stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL):
        reason = ('{0} is not installed: install the package {1} (Debian, if it has it) or '
                  'ros-noetic-{1}'.format(given.package, given.package.replace('_', '-')))
    else:
        reason = display.problem()
        if not reason:
            os.execvp('rosrun', ['rosrun', given.package, given.program, *given.arguments])
        reason += ': set DISPLAY, or look at the page (web:=true)'
    sys.stderr.write('[{}] no window: {}\n'.format(name, reason))
    return 0


if __name__ == '__main__':
    sys.exit(main())
