#!/usr/bin/env python3
"""Run a command, and end it with all that it has started when the standard input is closed.

usage: supervisor.py COMMAND ...

The other end of the standard input is held by the process of a test: however that ends, also by
kill -9, nothing of the command is left. roslaunch starts each node in a separate session, and
leaves it behind if it is killed itself.
"""
import os
import select
import signal
import subprocess
import sys
import time

from img_recog.processes import process_tree

# seconds after the end of the input, and the signal that is sent to all then; roslaunch has the
# time before to end its nodes itself
_ESCALATION = ((5.0, signal.SIGTERM), (8.0, signal.SIGKILL))
_POLL_PERIOD_S = 0.2


def main(command):
    """Run the command; return its exit code."""
    process_tree.adopt_orphans()
    woken, wake = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL)
    while process.poll() is None and not _is_closed(woken):
        pass
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
    _end_all(process, woken)
    code = process.returncode
    return code if code >= 0 else 128 - code


def _is_closed(woken):
    """Wait for the end of the input, or of a child; return whether it was the input."""
    readable, _, _ = select.select([sys.stdin, woken], [], [])
    if woken in readable:
        os.read(woken, 4096)
    return sys.stdin in readable and not os.read(sys.stdin.fileno(), 4096)


def _end_all(process, woken):
    """Wait until no process is left; send the signals of _ESCALATION meanwhile."""
    began_s, due = time.monotonic(), list(_ESCALATION)
    while True:
        process.poll()          # first: reap would take its exit code
        if process.returncode is not None:
            process_tree.reap()
        left = process_tree.descendants()
        if not left and process.returncode is not None:
            return
        passed_s = time.monotonic() - began_s
        if passed_s > due[0][0]:
            process_tree.send(due[0][1], left)
            due = due[1:] or due
        select.select([woken], [], [], _POLL_PERIOD_S)
        try:
            os.read(woken, 4096)
        except BlockingIOError:
            pass


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
