#!/usr/bin/env python3
"""Start a node again when it dies, but not when it ends because of what the user gave.

The launch-prefix of the nodes in the launch files, which also have respawn="true": roslaunch
starts this program again if it is killed itself. The node is a child process that ends with it,
and both end with roslaunch, even if that is killed.
roslaunch's respawn alone would start a node that refuses its input again and again, and roslaunch
does not take it beside required="true", by which the demo ends then.

The node is started again after a signal (kill -9, a crash), after an unexpected exception (exit
code 70), when no master answers (75), and after a shutdown from outside (77, as by rosnode kill).
After any other exit code it is not: the reason is printed, and with --required, or after 78 (a
parameter has a value that is not allowed), roslaunch is interrupted. Else this program waits for
roslaunch to end it, because roslaunch would start it again whatever its exit code is.
"""
import argparse
import contextlib
import functools
import os
import signal
import subprocess
import sys
import time

from img_recog.command_line import programs
from img_recog.processes import launch_output, process_tree, signals

# those of img_recog.ros.lifecycle, which this program does not import: it must start fast, and
# also when a package is missing
_STARTED_AGAIN = {70: 'unexpected exception', 75: 'no master answers',
                  77: 'shut down from outside'}
_FINISHED = {0: 'it has finished', 76: 'another node has taken its name'}
_REFUSED = 78
_LONG_LIFE_S = 4.0              # a node that lived so long is started again at once
_FIRST_DELAY_S, _MAX_DELAY_S = 0.5, 5.0
_POLL_PERIOD_S = 0.1
_PARENT_ENDED = signal.SIGUSR1
_SIGNALS = *signals.ENDING, _PARENT_ENDED
_END_LIMIT_S = 15               # the time that roslaunch gives a node to end
# roslaunch that is interrupted while it starts nodes may wait for its own locks
_MIN_AGE_TO_INTERRUPT_S = 2.0


class Respawner:
    """Runs a command again and again."""

    def __init__(self, command, required):
        self._command, self._required = command, required
        self._name = _value('__name:=', command) or os.path.basename(command[0])
        self._began_s = time.monotonic()
        self._parent = os.getppid()
        self._child = None
        self._signum = 0        # the signal that this process got

    def run(self):
        """Return the exit code after a signal to this process, once the command has ended."""
        signals.handle(self._forward)
        signal.signal(_PARENT_ENDED, self._end_with_parent)
        process_tree.end_with_parent(_PARENT_ENDED)
        self._end_with_parent()         # it may have been killed before
        delay_s = 0.0
        while True:
            started_s = time.monotonic()
            status = self._run_once()
            if self._signum:
                return status if status >= 0 else 128 - status
            if time.monotonic() - started_s > _LONG_LIFE_S:
                delay_s = 0.0
            if status >= 0 and status not in _STARTED_AGAIN:
                self._give_up(status)
                return status
            self._say('{}, started again{}'.format(
                _STARTED_AGAIN.get(status) or launch_output.described(status),
                ' in {:g} s'.format(delay_s) if delay_s else ''))
            self._wait(delay_s)
            if self._signum:
                return 0
            delay_s = min(_MAX_DELAY_S, max(_FIRST_DELAY_S, 2 * delay_s))

    def _run_once(self):
        """Run the command; return its exit code, or the negative number of its signal."""
        # no signal may come between its start and the assignment
        signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        if self._signum:
            return 0
        try:
            self._child = subprocess.Popen(
                self._command, env={**os.environ, 'IMG_RECOG_RESPAWN': '1'},
                preexec_fn=functools.partial(_become_node, os.getpid()))
        except OSError as error:
            sys.stderr.write('{}: {}\n'.format(self._command[0], error.strerror))
            return 127
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
        return self._child.wait()

    def _forward(self, signum, _):
        self._signum = signum
        if self._child and self._child.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._child.pid, signum)

    def _end_with_parent(self, *_):
        # the kernel also sends the signal when only the thread that started this program ends
        if self._is_orphan():
            # if the node does not end, this ends both: the kernel kills the node with its parent
            signal.alarm(_END_LIMIT_S)
            self._forward(signal.SIGTERM, None)

    def _is_orphan(self):
        # roslaunch runs in Python; init, our parent if it was killed before we looked, does not
        return os.getppid() != self._parent or not _is_python(self._parent)

    def _give_up(self, code):
        reason = (_FINISHED.get(code)
                  or launch_output.last_error(_value('__log:=', self._command))
                  or launch_output.described(code))
        if self._required or code == _REFUSED:
            self._say('ended, and the demo with it: {}'.format(reason))
            self._wait(self._began_s + _MIN_AGE_TO_INTERRUPT_S - time.monotonic())
            if not self._signum and not self._is_orphan():
                os.kill(self._parent, signal.SIGINT)
        else:
            self._say('ended and is not started again: {}'.format(reason))
        signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        while not (self._signum or self._is_orphan()):
            if signal.sigwait(_SIGNALS) != _PARENT_ENDED:
                break

    def _wait(self, delay_s):
        end_s = time.monotonic() + delay_s
        while time.monotonic() < end_s and not self._signum:
            time.sleep(_POLL_PERIOD_S)

    def _say(self, text):
        sys.stderr.write('[respawn] {}: {}\n'.format(self._name, text))
        sys.stderr.flush()


def _become_node(parent):
    # its own group: roslaunch signals the whole group, and the node gets a signal once
    os.setpgid(0, 0)
    process_tree.end_with_parent(signal.SIGKILL)
    if os.getppid() != parent:          # it was killed before
        os._exit(1)
    signals.handle(signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)


def _is_python(process):
    with contextlib.suppress(OSError):
        return 'python' in os.path.basename(os.readlink('/proc/{}/exe'.format(process)))
    return False


def _value(prefix, words):
    return next((word[len(prefix):] for word in words if word.startswith(prefix)), '')


def main():
    """Run the command line; return the exit code."""
    parser = programs.parser('respawn.py', __doc__,
                             formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--required', action='store_true',
                        help='end the demo with a node that is not started again')
    parser.add_argument('node', metavar='NODE')
    parser.add_argument('arguments', metavar='ARGUMENT', nargs=argparse.REMAINDER)
    given = parser.parse_args()
    return Respawner([given.node, *given.arguments], given.required).run()


if __name__ == '__main__':
    sys.exit(main())
