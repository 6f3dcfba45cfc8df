"""Waiting for a condition up to a deadline, for tests that must never sleep and hope."""
import threading
import time

DEADLINE_S = 90.0           # wall time, generous: the machine may be busy
_POLL = threading.Event()   # never set; waiting on it is how a poll passes the time


def wait_for(condition, what, deadline_s=DEADLINE_S):
    """Return the first true value of `condition()`; fail naming `what` after the deadline.

    what: a text, or a function that gives one when it is too late.
    """
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        _POLL.wait(0.02)
    raise AssertionError('waited {} s in vain for {}'.format(
        deadline_s, what() if callable(what) else what))
