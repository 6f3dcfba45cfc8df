"""The samples of colors that visitors mark in pictures of a camera, and the bounds for them."""
import os
import shutil
import tempfile
import threading
from multiprocessing.connection import Connection
from typing import Any, Callable, Dict, NamedTuple, Tuple

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.nodes.web.pictures import PictureTopics, encoded
from img_recog.nodes.web.tuning import FOLDER_ADVICE, saving, wait_until
from img_recog.processes.helper_process import HelperProcess
from img_recog.recognition.fitting import marked
from img_recog.recognition.fitting.marked import Marked
from img_recog.recognition.fitting.offers import Offer, offers

_FIT_TIMEOUT_S, _NICENESS = 120.0, 5
_fitting = threading.Lock()     # one search at a time in this program


class SamplesState(NamedTuple):
    """What all pages of a robot share; offers: for the samples, or else is_searching.

    problem: why there are no offers.
    """

    marked: Marked = Marked()
    offers: Dict[str, Offer] = {}
    is_searching: bool = False
    problem: str = ''


class ColorSamples:
    """Samples in pictures of one topic. For any thread; most methods wait: not for the event loop.

    After each change, bounds are searched in another process. state: replaced by each change.
    """

    def __init__(self, topic: str, pictures: PictureTopics):
        """Keep nothing yet."""
        self._topic, self._pictures = topic, pictures
        self._lock = threading.Lock()
        self._saved: Tuple[Any, str] = (None, '')
        self.state = SamplesState()

    def freeze(self) -> str:
        """Keep the newest picture; return its name. Waits for a moment until there is one."""
        wait_until(lambda: self._pictures.latest(self._topic))
        image = self._pictures.image(self._topic)
        if image is None:
            raise UserError('there is no picture of {}'.format(self._topic),
                            'try again when there is one')
        with self._lock:
            kept, name = marked.with_picture(self.state.marked, image)
            self.state = self.state._replace(marked=kept)
        return name

    def mark(self, picture: str, color: str, *place: float) -> str:
        """Add a sample in a picture, '' for the newest one; return the name of the picture.

        place: x and y of a point, or x, y, width and height; shares of width and height.
        """
        picture = picture or self.freeze()
        add: Any = marked.with_click if len(place) == 2 else marked.with_rectangle
        self._change(lambda now: add(now, picture, *place, color=color))
        return picture

    def remove(self, number: int) -> None:
        """Remove a sample."""
        self._change(lambda now: marked.without(now, number))

    def set_rest(self, is_none: bool) -> None:
        """Set whether what is not marked in a picture with samples has none of the colors."""
        self._change(lambda now: now._replace(rest_is_none=is_none))

    def shown(self, picture: str) -> Tuple[bytes, Any]:
        """Return a picture as JPEG, and the lines around its samples."""
        now = self.state.marked
        return encoded(now.image(picture)), marked.outlines(now, picture)

    def save(self) -> str:
        """Write the samples with their pictures to a new folder; return its path."""
        with saving:
            now = self.state.marked
            content, path = (now.samples, now.rest_is_none), self._saved[1]
            if not now.colors:
                raise UserError('there is no sample of a color', 'mark one in the camera picture')
            if self._saved[0] == content and os.path.isdir(path):
                return path
            path = files.free_output_path('samples', '')
            with files.refusal(path, FOLDER_ADVICE):
                folder = tempfile.mkdtemp(prefix='.samples', dir=os.path.dirname(path))
                try:
                    marked.write(now, folder)
                    os.chmod(folder, 0o755)
                    os.rename(folder, path)
                finally:
                    shutil.rmtree(folder, ignore_errors=True)
            self._saved = content, path
        return path

    def _change(self, change: Callable[[Marked], Marked]) -> None:
        with self._lock:
            is_idle = not self.state.is_searching
            self.state = SamplesState(change(self.state.marked), is_searching=True)
            if is_idle:
                threading.Thread(target=self._search, daemon=True).start()

    def _search(self) -> None:
        """Search bounds until nothing has changed meanwhile."""
        while True:
            now, found, problem = self.state.marked, {}, ''
            try:
                with _fitting:
                    found = offers_of_a_process(now, _FIT_TIMEOUT_S) if now.colors else {}
            except Exception as error:      # or else it would be searching for ever
                problem = one_line(error)
            with self._lock:
                # pictures may have come and gone
                if self.state.marked[1:3] == now[1:3]:
                    self.state = self.state._replace(
                        offers=found, is_searching=False, problem=problem)
                    return


def offers_of_a_process(now: Marked, timeout_s: float) -> Dict[str, Offer]:
    """Return what `offers` does, from a process that is ended after a time.

    The search takes hundreds of MB for some seconds. Raises UserError if there is no result.
    """
    process = HelperProcess(_send_offers, (now,), _NICENESS)
    try:
        if process.connection.poll(timeout_s):
            return process.connection.recv()
        raise UserError('the search of bounds took more than {:g} s'.format(timeout_s),
                        'mark fewer pictures')
    except EOFError:
        raise UserError('the search of bounds has ended: exit code {}'.format(process.wait()),
                        'see the log of the page')
    finally:
        process.kill()
        process.end()


def _send_offers(connection: Connection, now: Marked) -> None:
    connection.send(offers(now))
