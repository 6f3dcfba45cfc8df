"""What Python and rosout print for each line that they cannot write to their log."""
import os
import re

from img_recog.files import DISK_ERRORS

_BEGIN, _END = b'--- Logging error ---', b'Arguments: '
_OF_BLOCK = re.compile(
    rb'\s|$|--- Logging|Traceback |During |Call stack:|Message: |Arguments: |[\w.]+Error\b')
_DISK_ERROR = re.compile(rb'^OSError: \[Errno (?:%s)\] ([^:\n]*)' % b'|'.join(
    str(number).encode() for number in DISK_ERRORS), re.MULTILINE)
_FLUSHING = re.compile(rb"Error flushing rosout log file '[^']*': (%s)" % b'|'.join(
    re.escape(os.strerror(number).encode()) for number in DISK_ERRORS))
_STARTS = _BEGIN, b'Error flushing rosout'


class FullDiskFilter:
    """Removes these messages from an output; reason: the error of the system in one, or ''.

    Several processes print at the same time. After the first such error, no error of logging is
    passed.
    """

    def __init__(self):
        self.reason = ''
        self._open = 0                      # messages whose end has not come
        self._block = self._line = b''      # what is not decided yet

    def passed(self, data):
        """Return what is left of the output and can be decided; no data: the rest."""
        *lines, self._line = _FLUSHING.sub(self._noted, self._line + data).split(b'\n')
        found = b''.join(self._decided(line + b'\n') for line in lines)
        if not data or not (self._open or self._line and (
                self.reason or b'---' in self._line or self._line.endswith(b'-') or any(
                    self._line.startswith(start[:len(self._line)]) for start in _STARTS))):
            found, self._block, self._line = found + self._block + self._line, b'', b''
        return found

    def _decided(self, line):
        if _BEGIN not in line and not (self._open and _OF_BLOCK.match(line)):
            return line
        before = line.partition(_BEGIN)[0] if _BEGIN in line else b''
        self._open = max(0, self._open + line.count(_BEGIN) - line.count(_END))
        self._block += line[len(before):]
        _DISK_ERROR.sub(self._noted, self._block)
        before += b'\n' if before else b''
        if self._open and not self.reason:
            return before
        block, self._block = self._block, b''
        return before + (b'' if self.reason else block)

    def _noted(self, error):
        self.reason = error.group(1).decode(errors='replace')
        return b''
