"""Handlers of the log that keep a node running: no log file, a full disk, a closed terminal."""
import itertools
import logging
import os
import sys
from logging.handlers import RotatingFileHandler
from typing import Any, Iterator, Optional, Set

from rosgraph import roslogging

from img_recog.errors import one_line, shortened

_MAX_REASONS = 5
_CHECK_LINES = 100      # a file may become so many lines larger than rosgraph's limit
_configure, _renew_link = roslogging.configure_logging, roslogging.renew_latest_logdir


def install() -> None:
    """Have rospy.init_node make handlers that never end the node; call it before.

    An error of a handler costs one line on the terminal, the first time; python's logging would
    print a traceback for each record, and rosgraph's handler would raise it in the caller. If the
    log file cannot be written, the log is on the terminal alone; rosgraph would raise the error.
    The link `latest` to the folder of the log is left as it is if it is right: nodes that start at
    the same time would remove one another's.
    """
    roslogging.configure_logging = _configure_and_guard
    roslogging.renew_latest_logdir = _renew_wrong_link


def _renew_wrong_link(folder: str) -> bool:
    link = os.path.join(os.path.dirname(folder), 'latest')
    return os.path.realpath(link) == os.path.realpath(folder) or _renew_link(folder)


def _configure_and_guard(*args: Any, **options: Any) -> Optional[str]:
    """Replaces rosgraph's function: return the name of the log file, None if there is none."""
    path = None
    try:
        path = _configure(*args, **options)
    except (OSError, ValueError, roslogging.LoggingException) as error:
        reason = error.__cause__ or error       # of a ValueError of logging.config
        sys.stderr.write('[WARN] there is no log file, only the terminal: cannot write {}: {}; '
                         'set ROS_HOME or ROS_LOG_DIR to a folder that can be written\n'.format(
                             shortened(getattr(reason, 'filename', None) or 'it'),
                             one_line(reason)))
    if path is None:
        logging.getLogger().addHandler(logging.NullHandler())
        logging.getLogger('rosout').setLevel(logging.INFO)
        logging.getLogger('rosout').addHandler(roslogging.RosStreamHandler())
    protect()
    return path


def protect() -> None:
    """Have the handlers of this process report errors as `install` says."""
    for handler in ros_handlers():
        if isinstance(handler, RotatingFileHandler):
            _check_size_seldom(handler)
        _guard(handler)


def ros_handlers() -> Iterator[logging.Handler]:
    """Yield the handlers of rospy's log: for the file, the terminal and /rosout."""
    for name in ('rosout', None):
        yield from logging.getLogger(name).handlers


def _check_size_seldom(handler: RotatingFileHandler) -> None:
    """Have a handler look at the size of its file only now and then.

    For that it formats the line, and asks the system four times: a frame of color_extract, which
    logs a line, takes 3 % more CPU time at 640x480.
    """
    is_full, lines = handler.shouldRollover, itertools.count()
    setattr(handler, 'shouldRollover', lambda record: (
        next(lines) % _CHECK_LINES == 0 and is_full(record)))


class _Notice:
    """Replaces `handleError` of a handler: says once for each reason what is not written."""

    def __init__(self, target: str):
        self._target = target
        self._said: Set[str] = set()

    def __call__(self, _: logging.LogRecord) -> None:
        reason = one_line(sys.exc_info()[1])
        if reason in self._said or len(self._said) == _MAX_REASONS:
            return
        self._said.add(reason)
        try:
            sys.stderr.write(
                '[WARN] cannot write to {}: {}; lines of the log are missing there until it can '
                'be written again\n'.format(shortened(self._target), reason))
        except (OSError, ValueError):       # the terminal is gone too
            pass


def _guard(handler: logging.Handler) -> None:
    emit, notice = handler.emit, _Notice(getattr(handler, 'baseFilename', 'the terminal'))

    def guarded(record: logging.LogRecord) -> None:
        try:
            emit(record)
        except Exception:
            notice(record)
    setattr(handler, 'emit', guarded)
    setattr(handler, 'handleError', notice)
