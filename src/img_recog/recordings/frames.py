"""What all recordings have in common: frames, and a count of those that cannot be used."""
import abc
from typing import Any, Iterator, List, NamedTuple, Tuple

import numpy as np

from img_recog.errors import UserError

SECOND_NS = 10 ** 9
WANTED = 'give a video that FFmpeg plays, a folder of images, or a bag with images'


class Frame(NamedTuple):
    """An image and its stamp.

    number: counted from 0; stamp_ns: on the clock of the recording; header: a std_msgs/Header;
    image: uint8 of shape (height, width, 3 or 4); encoding: one of areas.ENCODINGS.
    """

    number: int
    stamp_ns: int
    header: Any
    image: np.ndarray
    encoding: str


class Part(NamedTuple):
    """A part of a recording.

    first: number of its first frame; frames: how many it has, 0 if unknown.
    In a bag, topic: of the images; begin_ns, end_ns: when the first and the last one was recorded.
    In a film, ticks: the times of its frames in the unit of the stream; stamps_ns: their stamps.
    Both are empty for a whole film.
    """

    first: int
    frames: int
    topic: str = ''
    begin_ns: int = 0
    end_ns: int = 0
    ticks: Tuple[int, ...] = ()
    stamps_ns: Tuple[int, ...] = ()


class Remarks(NamedTuple):
    """How many images of a recording can be used, and what else is to be said of it.

    skipped: how many cannot be used; first: which one is the first of them, and why; topic: of
    the images in a bag; warnings: other lines.
    """

    used: int = 0
    skipped: int = 0
    first: str = ''
    topic: str = ''
    warnings: Tuple[str, ...] = ()

    def plus(self, other: 'Remarks') -> 'Remarks':
        """Return these and those on what follows.

        >>> Remarks(9).plus(Remarks(1, 2, 'message 9: no pixels')).plus(Remarks(0, 1, 'other'))
        Remarks(used=10, skipped=3, first='message 9: no pixels', topic='', warnings=())
        """
        return Remarks(self.used + other.used, self.skipped + other.skipped,
                       self.first or other.first, self.topic or other.topic,
                       self.warnings + other.warnings)

    def lines(self, path: str) -> List[str]:
        """Return what to say of the recording at a path; raise UserError if no image is usable."""
        on_topic = ' on ' + self.topic if self.topic else ''
        if not self.used:
            raise UserError('no image{} in {} can be used; {}'.format(
                on_topic, path, self.first or 'there is none'))
        return [*self.warnings, *(['{} of {} images{} cannot be used; the first is {}'.format(
            self.skipped, self.skipped + self.used, on_topic, self.first)]
            if self.skipped else [])]


class Frames(abc.ABC):
    """The frames of a recording, or of a part of it.

    expected: their expected number, 0 if unknown; period_ns: how long the last one is shown,
    complete after it; remarks: on what was read so far; warnings: the same as lines, complete
    after the last frame.
    """

    expected: int
    period_ns: int

    def __init__(self, path: str, topic: str = '') -> None:
        """Take the path of the recording, and the topic of the images in a bag."""
        self.path = path
        self.remarks = Remarks(topic=topic)
        self.warnings: List[str] = []

    def note(self, **values: Any) -> None:
        """Add remarks, given as values of Remarks."""
        self.remarks = self.remarks.plus(Remarks(**values))

    def note_damaged(self, count: int) -> None:
        """Add frames of a film that FFmpeg cannot decode; it does not say which they are."""
        if count:
            self.note(skipped=count, first='an empty or damaged frame of ' + self.path)

    @abc.abstractmethod
    def read(self) -> Iterator[Frame]:
        """Yield the usable frames; raise UserError if the recording is damaged."""

    def __iter__(self) -> Iterator[Frame]:
        """Yield the usable frames; raise UserError at the end if there was none."""
        yield from self.read()
        self.warnings = self.remarks.lines(self.path)
