"""Log records that cannot forge lines, control the terminal or grow without limit."""
import logging
from typing import Optional

from img_recog.errors import MAX_LINE, shortened

_TRACEBACK = 'Traceback (most recent call last)'
_INDENT = '    '            # of the lines of a traceback: none looks like a new record
_MAX_LINES = 60
_FIELD, _TIME_FIELDS = '${', ('${time:', '${walltime:')


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


def install() -> None:
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
