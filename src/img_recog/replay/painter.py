"""A process that draws the picture of a replay."""
import gc
import io
import multiprocessing
import signal
from multiprocessing.connection import Connection
from typing import Any

from img_recog.errors import UserError


class Painter:
    """Loads matplotlib and prepares a picture while others are at work, and then draws it.

    It is a process because threads would take turns with the rest of the program. Start it before
    there are threads and files: it is a fork. To leave the `with` ends it, whatever it is at.

    number: of the process.
    """

    def __init__(self):
        # the one that needs no program to be loaded again
        context = multiprocessing.get_context('fork')
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(self._ours, theirs), daemon=True)
        self._process.start()
        self.number = self._process.pid
        theirs.close()

    def __enter__(self) -> 'Painter':
        return self

    def __exit__(self, *_) -> None:
        self._ours.close()
        self._process.kill()
        self._process.join()

    def begin(self, title: str, numbers: Any) -> None:
        """Let it draw; numbers: PlotData."""
        try:
            self._ours.send((title, numbers))
        except OSError:
            pass        # it has ended, as `finish` finds

    def finish(self) -> bytes:
        """Return the picture as PNG, once it is there; UserError when there will be none."""
        try:
            return self._ours.recv_bytes()
        except (EOFError, OSError):
            self._process.join()
            raise UserError('the picture cannot be drawn: its process ended with exit code {}; '
                            'was it killed for want of memory?'.format(self._process.exitcode))


def _serve(parents: Connection, ours: Connection) -> None:
    # the program that started this one ends it, or is gone
    parents.close()
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    gc.disable()        # it lives so short that there is nothing to gain
    from img_recog.replay.figure import Picture
    picture, file = Picture(), io.BytesIO()
    try:
        title, numbers = ours.recv()
    except EOFError:
        return
    picture.draw(file, title, numbers)
    try:
        ours.send_bytes(file.getbuffer())
    except OSError:
        pass            # nobody waits for it any more
