"""A separate process that works for this one, and ends with it."""
import multiprocessing
import os
import queue
import select
import signal
import threading
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any, Callable, Optional, Tuple

from img_recog.processes import signals

_EXIT_TIMEOUT_S = 2.0       # of one that works, after its connection was closed
_LAST_TIMEOUT_S = 30.0      # of one that has closed its connection: a busy machine is slow
_END = object()             # the message after the last one
# Linux reports room for writing while a quarter of a socket's buffer of 208 kB is used at most
_AT_ONCE_BYTES = 1 << 16


class HelperProcess:
    """A process that runs `target(connection, *inherited, *args)`.

    The target returns when the other end of its connection is closed. connection: this end, to
    receive what the target sends. is_broken: whether a message could not be sent: the process has
    ended.
    """

    def __init__(self, target: Callable[..., None], args: Tuple, niceness: int,
                 inherited: Tuple = ()):
        """Start it.

        target: a function of a module. niceness: how far other processes come first. inherited:
        arguments that only a new process can get, like shared memory.
        """
        # a forked child would share descriptors and locks
        context = multiprocessing.get_context('spawn')
        self.connection, other = context.Pipe()
        self._process = context.Process(
            target=_run, args=(target, other, inherited, niceness), daemon=True)
        self._process.start()
        other.close()
        self._outbox: 'queue.Queue[Any]' = queue.Queue()
        self.is_broken = False
        threading.Thread(target=self._send_all, name='to the helper', daemon=True).start()
        self.send(args)

    def send(self, message: object) -> None:
        """Send a message; never waits, also if the process does not read."""
        data = ForkingPickler.dumps(message)
        # a thread gets it sent later, when others of this process let it
        if len(data) <= _AT_ONCE_BYTES and not self.is_sending and self._has_room():
            self._send_now(data)
        else:
            self._outbox.put(data)

    def _has_room(self) -> bool:
        """Return whether the connection takes _AT_ONCE_BYTES without waiting."""
        room = select.poll()
        try:
            room.register(self.connection, select.POLLOUT)
            return bool(room.poll(0))
        except (OSError, ValueError):       # `end` has closed it
            return False

    def _send_now(self, data: Any) -> None:
        try:
            self.connection.send_bytes(data)
        except Exception:       # the process has ended, or `end` has closed the connection
            self.is_broken = True

    @property
    def is_sending(self) -> bool:
        """Whether the process has not taken all messages yet."""
        return self._outbox.unfinished_tasks > 0

    def _send_all(self) -> None:
        while not self.is_broken:
            message = self._outbox.get()
            if message is _END:
                return
            self._send_now(message)
            self._outbox.task_done()

    def wait(self, timeout_s: float = _LAST_TIMEOUT_S) -> Optional[int]:
        """Wait for the exit of a process that has closed its connection; return its exit code.

        If it does not exit in this time, it is killed.
        """
        self._process.join(timeout_s)
        if self._process.exitcode is None:
            self.kill()
            self._process.join()
        return self._process.exitcode

    def kill(self) -> None:
        """End the process at once, even one that hangs or is stopped."""
        self._process.kill()

    def end(self) -> Optional[int]:
        """Close the pipe, wait for the process to exit, or kill it; return its exit code."""
        self._outbox.put(_END)
        self.connection.close()
        return self.wait(_EXIT_TIMEOUT_S)


def _run(target: Callable[..., None], connection: Connection, inherited: Tuple, niceness: int
         ) -> None:
    # Ctrl-C reaches the whole process group; this process exits when its parent does
    signals.handle(signal.SIG_IGN, [signal.SIGINT])
    os.nice(niceness)
    try:
        args = connection.recv()
    except (EOFError, OSError):
        return
    target(connection, *inherited, *args)
