"""Handlers of the log that keep a node running: a full disk, a closed terminal, large files."""
import logging
import os
import stat
import sys
from logging.handlers import RotatingFileHandler
from typing import Iterator, Set

from rosgraph.roslogging import RosStreamHandler

from img_recog.errors import one_line, shortened

_CONFIGURATION = 'ROS_PYTHON_LOG_CONFIG_FILE'
_DEFAULT_SIZE = 50000000, 4     # rosgraph's limit: bytes of a file, number of older files
_SIZE = 10000000, 4             # ours, 50 MB for a node, which is five hours of color_extract
_MAX_REASONS = 5
_wrong_lines: Set[str] = set()      # that were said


def protect() -> None:
    """Change the handlers of this process, once. Call it after rospy has made them.

    An error of a handler costs one line on the terminal, the first time; python's logging would
    print a traceback for each record, and rosgraph's handler would raise it in the caller. Log
    files are smaller than rosgraph's, unless the user has chosen a configuration.
    """
    for handler in ros_handlers():
        if {'emit', 'handleError'} & set(vars(handler)):        # changed before
            continue
        if isinstance(handler, RosStreamHandler):
            _guard(handler)
        elif isinstance(handler, logging.FileHandler):
            setattr(handler, 'handleError', _Notice(handler.baseFilename))
        if isinstance(handler, RotatingFileHandler) and not os.environ.get(_CONFIGURATION):
            _limit(handler)


def ros_handlers() -> Iterator[logging.Handler]:
    """Yield the handlers of rospy's log: for the file, the terminal and /rosout."""
    for name in ('rosout', None):
        yield from logging.getLogger(name).handlers


def _limit(handler: RotatingFileHandler) -> None:
    if (handler.maxBytes, handler.backupCount) == _DEFAULT_SIZE:
        vars(handler).update(zip(('maxBytes', 'backupCount'), _SIZE))
        setattr(handler, 'shouldRollover', lambda record: _is_full(handler))


def _is_full(handler: RotatingFileHandler) -> bool:
    """Return whether the file has its size; the original formats the line to know its length."""
    if handler.stream is None:      # it could not be opened after the last change of files
        handler.stream = handler._open()
    status = os.fstat(handler.stream.fileno())
    return stat.S_ISREG(status.st_mode) and status.st_size >= _SIZE[0]


class _Notice:
    """Replaces `handleError` of a handler: says once for each reason what is not written.

    A record whose text does not fit its values is no fault of what is written to.
    """

    def __init__(self, target: str):
        self._target = target
        self._said: Set[str] = set()

    def __call__(self, record: logging.LogRecord) -> None:
        reason, said = one_line(sys.exc_info()[1]), self._said
        line = ('cannot write to {}: {}; lines of the log are missing there until it can be '
                'written again'.format(shortened(self._target), reason))
        try:
            record.getMessage()
        except Exception as error:      # the same for all handlers
            said = _wrong_lines
            line = reason = 'a line of the log is left out: the text {!r} in {}, line {}, does ' \
                'not fit its values: {}; correct it'.format(
                    shortened(record.msg), record.filename, record.lineno, one_line(error))
        if reason in said or len(said) == _MAX_REASONS:
            return
        said.add(reason)
        try:
            sys.stderr.write('[WARN] {}\n'.format(line))
        except (OSError, ValueError):       # the terminal is gone too
            pass


def _guard(handler: logging.Handler) -> None:
    emit, notice = handler.emit, _Notice('the terminal')

    def guarded(record: logging.LogRecord) -> None:
        try:
            emit(record)
        except Exception:
            notice(record)
    setattr(handler, 'emit', guarded)
