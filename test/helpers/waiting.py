"""Waits for a condition up to a deadline, so that tests need no fixed sleep."""
import os
import threading
import time

DEADLINE_S = 90.0           # wall time on an idle machine, generous
_MAX_STRETCH = 5.0
_MIN_PAUSE_S, _MAX_PAUSE_S = 0.02, 1.0
_POLL = threading.Event()   # never set; waited for between two checks


def wait_for(condition, what, deadline_s=DEADLINE_S):
    """Return the first true value of `condition()`; raise AssertionError after the deadline.

    what: a description of what is waited for, or a function that returns it.
    deadline_s: seconds of wall time on an idle machine; longer while other programs run, see
    `stretch`.

    After a check that took long, such as one that starts a program, it waits longer, so that the
    checks do not slow down what is waited for.
    """
    start, checks, runnable = time.monotonic(), 0, 0
    while True:
        check_start = time.monotonic()
        value = condition()
        if value:
            return value
        # the load average needs a minute to show that other programs have just started
        checks, runnable = checks + 1, runnable + _runnable()
        if time.monotonic() > start + deadline_s * max(stretch(), _limited(runnable / checks)):
            break
        _POLL.wait(min(max(_MIN_PAUSE_S, 4 * (time.monotonic() - check_start)), _MAX_PAUSE_S))
    raise AssertionError('timeout after {:.0f} s waiting for {}'.format(
        time.monotonic() - start, what() if callable(what) else what))


def stretch():
    """Return by which factor a busy machine is slower: its load per core, from 1 to 5."""
    return _limited(os.getloadavg()[0])


def _limited(load):
    return min(max(load / (os.cpu_count() or 1), 1.0), _MAX_STRETCH)


def _runnable():
    """Return how many threads of this machine run or wait for a core now."""
    with open('/proc/loadavg') as file:
        return int(file.read().split()[3].partition('/')[0])
