"""Signals that end a program by an exception."""
import contextlib
import signal
import sys
from typing import Iterator, Optional


class Interrupts:
    """Has SIGINT raise KeyboardInterrupt, and SIGTERM and SIGHUP SystemExit of 128 and the number.

    So unfinished files are removed on the way out. One that is ignored, as nohup has it, stays so;
    SIGINT ends a program that a shell has in the background as well.
    """

    def __init__(self):
        self._is_held = False
        self._came: Optional[int] = None
        signal.signal(signal.SIGINT, self._leave)
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._leave)

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Leave only at the end of this: what it makes must not be left half made."""
        self._is_held = True
        try:
            yield
        finally:
            self._is_held = False
        if self._came is not None:
            self._leave(self._came, None)

    def _leave(self, number: int, _) -> None:
        if self._is_held:
            self._came = number
        elif number == signal.SIGINT:
            raise KeyboardInterrupt
        else:
            sys.exit(128 + number)
