"""Handlers of the log that keep a node running: no log file, a full disk, a closed terminal."""
import itertools
import logging
import os
import sys
from logging.handlers import RotatingFileHandler
from typing import Any, Iterator, Optional, Set

from rosgraph import roslogging

from img_recog.errors import MAX_LINE, one_line, shortened

_TRACEBACK = 'Traceback (most recent call last)'
_INDENT = '    '            # of the lines of a traceback: none looks like a new record
_MAX_LINES = 60
_FIELD, _TIME_FIELDS = '${', ('${time:', '${walltime:')
_MAX_REASONS = 5
_CHECK_LINES = 100      # a file may become so many lines larger than rosgraph's limit
_configure, _renew_link = roslogging.configure_logging, roslogging.renew_latest_logdir


class SafeRecord(logging.LogRecord):
    """A record whose texts are safe for the terminal, the log file and /rosout alike.

    The message may contain anything that another node or a file contains, also in the lines of
    rospy itself.
    """

    _exc_text: Optional[str] = None

    def getMessage(self) -> str:        # noqa: N802 (the name of the logging package)
        """Return the message in one line; a traceback in it keeps its lines."""
        text = str(self.msg)
        if self.args:
            text = text % self.args
        if len(text) <= MAX_LINE and text.isprintable() and _FIELD not in text:
            return text
        return _lines(text) if _TRACEBACK in text else _without_fields(shortened(text, MAX_LINE))

    @property
    def exc_text(self) -> Optional[str]:
        """The traceback, which a Formatter sets."""
        return self._exc_text

    @exc_text.setter
    def exc_text(self, text: Optional[str]) -> None:
        self._exc_text = text and _lines(text)


def use_safe_records() -> None:
    """Make the records of all loggers of this process SafeRecords."""
    logging.setLogRecordFactory(SafeRecord)


def _lines(text: str) -> str:
    """Return a text with its line breaks, at most _MAX_LINES of them, and all else escaped."""
    lines = text.rstrip('\n').split('\n')
    dropped = len(lines) - _MAX_LINES
    if dropped > 0:
        half = _MAX_LINES // 2
        lines[half:-half] = ['... {} lines ...'.format(dropped)]
    return _without_fields(('\n' + _INDENT).join(shortened(line) for line in lines))


def _without_fields(text: str) -> str:
    """Change fields that rosgraph's handler would replace; it fails if one has no end."""
    for field in _TIME_FIELDS:
        text = text.replace(field, field.replace(_FIELD, '$ {'))
    return text


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
