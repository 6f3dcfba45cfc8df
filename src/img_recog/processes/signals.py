"""The signals that end a program."""
import atexit
import contextlib
import signal
import sys
from typing import Any, Iterator, Optional, Sequence

ENDING = signal.SIGINT, signal.SIGTERM, signal.SIGHUP


def handle(handler: Any, signums: Sequence[int] = ENDING) -> None:
    """Set the handler of signals that end the program.

    SIGHUP stays ignored if it is, as under nohup. The others also end a program that a script has
    started in the background, which ignores SIGINT.
    """
    for signum in signums:
        if signum != signal.SIGHUP or signal.getsignal(signum) != signal.SIG_IGN:
            signal.signal(signum, handler)


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Leave a Ctrl-C, which reaches the whole process group, to other processes."""
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)


class Interrupts:
    """Makes SIGINT raise KeyboardInterrupt, and SIGTERM and SIGHUP SystemExit(128 + signum).

    So unfinished files are removed before the program ends.
    """

    def __init__(self) -> None:
        self._is_deferred = False
        self._pending: Optional[int] = None
        handle(self._end)
        # an exception in the last calls of Python is just printed
        atexit.register(handle, signal.SIG_DFL)

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
