"""Ends a program by an exception when it receives a signal."""
import atexit
import contextlib
import signal
import sys
from typing import Iterator, Optional


class Interrupts:
    """Makes SIGINT raise KeyboardInterrupt, and SIGTERM and SIGHUP SystemExit(128 + signum).

    So unfinished files are removed before the program ends. SIGHUP stays ignored if it is, as
    under nohup. The others also end a program that a script has started in the background.
    """

    def __init__(self) -> None:
        self._is_deferred = False
        self._pending: Optional[int] = None
        for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signum != signal.SIGHUP or signal.getsignal(signum) != signal.SIG_IGN:
                signal.signal(signum, self._end)
        atexit.register(_end_at_once)

    @contextlib.contextmanager
    def deferred(self) -> Iterator[None]:
        """Handle signals only at the end of the `with`, whose work must not be interrupted."""
        self._is_deferred = True
        try:
            yield
        finally:
            self._is_deferred = False
        if self._pending is not None:
            self._end(self._pending, None)

    def _end(self, signum: int, _) -> None:
        if self._is_deferred:
            self._pending = signum
        elif signum == signal.SIGINT:
            raise KeyboardInterrupt
        else:
            sys.exit(128 + signum)


def _end_at_once() -> None:
    """Have signals end the program: an exception in the last calls of Python is just printed."""
    for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(signum) != signal.SIG_IGN:
            signal.signal(signum, signal.SIG_DFL)
