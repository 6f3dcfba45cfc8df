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
_POLL_PERIOD_S = 0.1


def main(command):
    """Run the command; return its exit code."""
    process_tree.adopt_orphans()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL)
    while process.poll() is None:
        if select.select([sys.stdin], [], [], _POLL_PERIOD_S)[0] and not os.read(0, 4096):
            process.send_signal(signal.SIGINT)
            break
    began_s, due = time.monotonic(), list(_ESCALATION)
    while process.poll() is None or process_tree.descendants():
        if time.monotonic() - began_s > due[0][0]:
            process_tree.send(due[0][1], process_tree.descendants())
            due = due[1:] or due
        time.sleep(_POLL_PERIOD_S)
    code = process.returncode
    return code if code >= 0 else 128 - code


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
