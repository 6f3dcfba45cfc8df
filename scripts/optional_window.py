#!/usr/bin/env python3
"""Start a program of another package that opens a window, or say how to install it.

usage: optional_window.py PACKAGE PROGRAM [ARGUMENT ...]

roslaunch ends with an error for a node whose package is missing; the demo goes on without a window
that is not needed.
"""
import os
import subprocess
import sys


def main(arguments):
    """Replace this process by the program; return the exit code if that cannot be."""
    if arguments[:1] in (['-h'], ['--help']):
        sys.stdout.write(__doc__)
        return 0
    if len(arguments) < 2:
        sys.stderr.write('optional_window.py: expected PACKAGE PROGRAM [ARGUMENT ...]\n')
        return 2
    package, program = arguments[:2]
    name = next((word.partition(':=')[2] for word in arguments if word.startswith('__name:=')),
                program)
    found = subprocess.run(['rospack', 'find', package], stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, check=False).returncode == 0
    if not found:
        return _skip(name, '{} is not installed: install the package {} (Debian, if it has it) or '
                     'ros-noetic-{}'.format(package, package.replace('_', '-'),
                                            package.replace('_', '-')))
    if not os.environ.get('DISPLAY'):
        return _skip(name, 'there is no display: set DISPLAY, or look at the page (web:=true)')
    os.execvp('rosrun', ['rosrun', *arguments])


def _skip(name, reason):
    sys.stderr.write('[{}] no window: {}\n'.format(name, reason))
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
