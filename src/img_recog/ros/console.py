"""Log lines that the terminal does not show; /rosout and the log file have them all."""
import logging
import time
from typing import Any, Callable, Optional

from rosgraph.roslogging import RosStreamHandler

_ON_CONSOLE = 'on_console'      # attribute of a record


class ConsoleThrottle:
    """Chooses, of the lines about something that changes, those that the terminal shows.

    The first line is shown; after it, a line about a state that differs from the one shown last,
    as soon as `period_s` of wall time have passed since then.
    """

    def __init__(self, period_s: float = 1.0, now: Callable[[], float] = time.monotonic):
        self._period_s, self._now = period_s, now
        self._shown: Any = None
        self._shown_s: Optional[float] = None

    def shows(self, state: Any) -> bool:
        """Return whether the line about `state` is to be shown."""
        now_s = self._now()
        if self._shown_s is not None and (state == self._shown
                                          or now_s - self._shown_s < self._period_s):
            return False
        self._shown, self._shown_s = state, now_s
        return True


def mark(shown: bool) -> dict:
    """Return the `extra` of a call of rospy.loginfo: whether the terminal shows the line."""
    return {_ON_CONSOLE: shown}


def install_filter() -> None:
    """Let the terminal leave out the lines that are marked so; call it after rospy.init_node."""
    for name in ('rosout', None):
        for handler in logging.getLogger(name).handlers:
            if isinstance(handler, RosStreamHandler):
                handler.addFilter(_is_on_console)


def _is_on_console(record: logging.LogRecord) -> bool:
    return getattr(record, _ON_CONSOLE, True)
