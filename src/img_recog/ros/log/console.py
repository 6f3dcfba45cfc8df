"""Hide some log lines in the terminal only; /rosout and the log file get all lines."""
import logging
import time
from typing import Any, Callable, Optional

from rosgraph.roslogging import RosStreamHandler

from img_recog.ros.log import log_handlers

_ON_CONSOLE = 'on_console'      # attribute of a LogRecord


class ConsoleThrottle:
    """Decides which of many lines about a changing state the terminal shows.

    The first line is shown. After that, a line is shown if its state differs from the state shown
    last, and at least `period_s` seconds of wall time have passed since then.
    """

    def __init__(self, period_s: float = 1.0, now: Callable[[], float] = time.monotonic):
        self._period_s, self._now = period_s, now
        self._shown: Any = None
        self._shown_s: Optional[float] = None

    def shows(self, state: Any) -> bool:
        """Return whether to show a line about `state`."""
        now_s = self._now()
        if self._shown_s is not None and (state == self._shown
                                          or now_s - self._shown_s < self._period_s):
            return False
        self._shown, self._shown_s = state, now_s
        return True


def mark(shown: bool) -> dict:
    """Return the argument `extra` for rospy.loginfo: whether the terminal shows the line."""
    return {_ON_CONSOLE: shown}


def install_filter() -> None:
    """Hide the lines with `mark(False)` in the terminal. Call it after rospy.init_node."""
    for handler in log_handlers.ros_handlers():
        if isinstance(handler, RosStreamHandler):
            handler.addFilter(_is_on_console)


def _is_on_console(record: logging.LogRecord) -> bool:
    return getattr(record, _ON_CONSOLE, True)
