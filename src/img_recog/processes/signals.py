"""The signals that end a program."""
import atexit
import contextlib
import os
import signal
import sys
import threading
from typing import Any, Callable, Iterator, Optional, Sequence

ENDING = signal.SIGINT, signal.SIGTERM, signal.SIGHUP


def handle(handler: Any, signums: Sequence[int] = ENDING) -> None:
    """Set the handler of signals that end the program.

    SIGHUP stays ignored if it is, as under nohup. The others also end a program that a script has
    started in the background, which ignores SIGINT.
    """
    for signum in signums:
        if signum != signal.SIGHUP or signal.getsignal(signum) != signal.SIG_IGN:
            signal.signal(signum, handler)


def act_at_once(action: Callable[[int], None]) -> None:
    """Call `action` with the number of each signal that ends the program: twice, in two threads.

    The main thread calls it when it runs Python code again. For a signal that comes just before it
    begins to wait in a library, that is when the wait ends; so another thread calls it, too.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    handle(lambda signum, _: action(signum))

    def wait() -> None:
        while True:
            for signum in os.read(reader, 64):
                if signum in ENDING:
                    action(signum)
    threading.Thread(target=wait, name='signals', daemon=True).start()


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Have threads and processes that are started in the block take no Ctrl-C.

    A Ctrl-C reaches the whole process group. For this thread, the kernel keeps it until the end of
    the block.
    """
    # imported here because few need it
    from multiprocessing import resource_tracker
    resource_tracker.ensure_running()       # its start would let the thread take signals again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


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
