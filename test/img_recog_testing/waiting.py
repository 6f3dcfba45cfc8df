"""Waits for a condition up to a deadline, so that tests need no fixed sleep."""
import threading
import time

DEADLINE_S = 90.0           # wall time, generous: the machine may be busy
_POLL = threading.Event()   # never set; waited for between two checks


def wait_for(condition, what, deadline_s=DEADLINE_S):
    """Return the first true value of `condition()`; raise AssertionError after the deadline.

    what: a description of what is waited for, or a function that returns it.
    """
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        _POLL.wait(0.02)
    raise AssertionError('timeout after {} s waiting for {}'.format(
        deadline_s, what() if callable(what) else what))
