"""Single key presses from a terminal."""
import contextlib
import os
import select
import sys
import termios
import time
import tty
from typing import Optional


class Keyboard:
    """Reads keys without Enter while it is used as a context.

    present: whether there are keys to read. There are if standard input is the terminal in whose
    foreground this process runs: a process in the background, or one that roslaunch has put into
    a session of its own, would steal the keys of the shell. Without them, `key` merely waits.
    """

    def __init__(self, stream=None):
        self._stream = sys.stdin if stream is None else stream
        self._saved = None
        self.present = _in_foreground(self._stream)

    def __enter__(self) -> 'Keyboard':
        if self.present:
            self._saved = termios.tcgetattr(self._stream)
            tty.setcbreak(self._stream.fileno())
        return self

    def __exit__(self, *_):
        if self._saved is not None:
            # a terminal that is gone has no settings left to restore
            with contextlib.suppress(termios.error):
                termios.tcsetattr(self._stream, termios.TCSADRAIN, self._saved)
            self._saved = None

    def key(self, timeout_s: float) -> Optional[str]:
        """Return the next key pressed within `timeout_s`, else None."""
        if not self.present:
            time.sleep(timeout_s)
            return None
        readable, _, _ = select.select([self._stream], [], [], timeout_s)
        if not readable:
            return None
        # from the descriptor: sys.stdin would buffer keys where select cannot see them
        try:
            pressed = os.read(self._stream.fileno(), 1)
        except OSError:
            pressed = b''
        self.present = bool(pressed)        # no byte, or an error: the terminal is gone
        return pressed.decode('ascii', 'replace') or None


def _in_foreground(stream) -> bool:
    try:
        return stream.isatty() and os.tcgetpgrp(stream.fileno()) == os.getpgrp()
    except (AttributeError, OSError, ValueError):
        return False
