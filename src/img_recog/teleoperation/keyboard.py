"""Reads single keys from a terminal."""
import contextlib
import os
import select
import sys
import termios
import time
import tty
from typing import Any, List, Optional


class Keyboard:
    """Reads keys without waiting for Enter; to be used in a `with` statement.

    present: whether keys can be read. If False, `key` only waits.

    Args:
        is_in_foreground: Whether the standard input is a terminal that has this process in its
            foreground. A process in the background would take the keys away from the shell.
    """

    def __init__(self, is_in_foreground: bool):
        self._stream = sys.stdin
        self._saved: Optional[List[Any]] = None
        self.present = is_in_foreground

    def __enter__(self) -> 'Keyboard':
        if self.present:
            self._saved = termios.tcgetattr(self._stream)
            tty.setcbreak(self._stream.fileno())
        return self

    def __exit__(self, *_):
        if self._saved is not None:
            # the terminal may have been closed
            with contextlib.suppress(termios.error):
                termios.tcsetattr(self._stream, termios.TCSADRAIN, self._saved)
            self._saved = None

    def key(self, timeout_s: float) -> Optional[str]:
        """Return the next key, None if none is pressed within `timeout_s`."""
        if not self.present:
            time.sleep(timeout_s)
            return None
        readable, _, _ = select.select([self._stream], [], [], timeout_s)
        if not readable:
            return None
        # not by sys.stdin.read: it buffers keys, which select then does not report
        try:
            pressed = os.read(self._stream.fileno(), 1)
        except OSError:
            pressed = b''
        self.present = bool(pressed)        # no byte or an error: it is closed
        return pressed.decode('ascii', 'replace') or None
