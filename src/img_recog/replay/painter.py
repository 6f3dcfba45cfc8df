"""Draws the picture of a replay in a separate process."""
import gc
import io
import multiprocessing
import signal
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from img_recog.errors import UserError

if TYPE_CHECKING:       # it imports numpy, and the process must start before that
    from img_recog.replay.plot_data import PlotData


class Painter:
    """A process that loads matplotlib while the replay runs, and then draws the picture.

    A thread would compete with the replay for the interpreter lock. The process is a fork: start
    it before there are threads and open files. At the end of the `with` it is killed.

    pid: id of the process.
    """

    def __init__(self):
        # fork: the other start methods load the program again
        context = multiprocessing.get_context('fork')
        self._connection, child_connection = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(self._connection, child_connection), daemon=True)
        self._process.start()
        self.pid = self._process.pid
        child_connection.close()

    def __enter__(self) -> 'Painter':
        return self

    def __exit__(self, *_) -> None:
        self._connection.close()
        self._process.kill()
        self._process.join()

    def begin(self, title: str, data: 'PlotData') -> None:
        """Start to draw."""
        try:
            self._connection.send((title, data))
        except OSError:
            pass        # the process has ended; `finish` raises the error

    def finish(self) -> bytes:
        """Return the picture as PNG when it is done; raise UserError if the process has ended."""
        try:
            return self._connection.recv_bytes()
        except (EOFError, OSError):
            self._process.join()
            problem = 'the picture cannot be drawn: its process ended with exit code {}'
            raise UserError(
                problem.format(self._process.exitcode),
                'check whether it was killed because memory ran out')


def _serve(parent_connection: Connection, connection: Connection) -> None:
    parent_connection.close()
    # this process is ended by its parent, or when the parent is gone
    for signum in (signal.SIGINT, signal.SIGHUP):
        signal.signal(signum, signal.SIG_IGN)
    gc.disable()        # the process is too short-lived for it to help
    from img_recog.replay.figure import ReplayFigure
    figure, file = ReplayFigure(), io.BytesIO()
    try:
        title, data = connection.recv()
    except EOFError:
        return
    figure.draw(file, title, data)
    try:
        connection.send_bytes(file.getbuffer())
    except OSError:
        pass            # the parent no longer waits for it
