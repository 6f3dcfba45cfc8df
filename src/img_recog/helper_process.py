"""A separate process that works for this one, and ends with it."""
import multiprocessing
import os
import signal
from multiprocessing.connection import Connection
from typing import Callable, Optional, Tuple

_EXIT_TIMEOUT_S = 2.0


class HelperProcess:
    """A process that runs `target(connection, *args)`; `connection` is this end of its pipe.

    The target returns when the other end of its connection is closed.
    """

    def __init__(self, target: Callable[..., None], args: Tuple, niceness: int):
        """Start it; target: a function of a module, niceness: how far others come first."""
        # a forked child would share descriptors and locks
        context = multiprocessing.get_context('spawn')
        self.connection, other = context.Pipe()
        self._process = context.Process(target=_run, args=(target, other, args, niceness),
                                        daemon=True)
        self._process.start()
        other.close()

    def wait(self) -> Optional[int]:
        """Wait for the exit of a process that must be about to exit; return its exit code.

        None if it does not exit within 2 s.
        """
        self._process.join(_EXIT_TIMEOUT_S)
        return self._process.exitcode

    def kill(self) -> None:
        """End the process at once, even one that hangs or is stopped."""
        self._process.kill()

    def end(self) -> Optional[int]:
        """Close the pipe, wait for the process to exit, or kill it; return its exit code."""
        self.connection.close()
        if self.wait() is None:
            self.kill()
        return self.wait()


def _run(target: Callable[..., None], connection: Connection, args: Tuple, niceness: int) -> None:
    # Ctrl-C reaches the whole process group; this process exits when its parent does
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(niceness)
    target(connection, *args)
