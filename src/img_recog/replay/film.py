"""A film of the system: camera, masked images, map and charts side by side."""
import io
from typing import Any, List, Optional, Sequence, Tuple

import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.settings import RecognitionSettings
from img_recog.replay.chain import SECOND_NS, CommandSent, FrameResult, Recorder
from img_recog.replay.film_picture import HEIGHT, WIDTH, FilmPicture, FilmState
from img_recog.replay.film_writer import FilmWriter

RATE_HZ = 30
_NO_SCAN = np.empty((0, 2))


class Film:
    """Writes states in the order of time; a film has RATE_HZ pictures a second."""

    def __init__(self, file: io.BufferedRandom, settings: RecognitionSettings,
                 outlines: Sequence[np.ndarray], path: str = ''):
        """Start a film in an open file.

        settings: of the colors. outlines: (corners, 2) in m of what stands in the world.
        path: of the film in messages, if the file has another name until it is complete.
        Raises UserError if there is no ffmpeg.
        """
        self._extractor = ColorExtractor(settings)
        self._numbers = range(len(settings.colors))
        self._picture = FilmPicture(settings.colors, outlines)
        self._writer = FilmWriter(file, WIDTH, HEIGHT, RATE_HZ, path)
        self._drawn: Optional[np.ndarray] = None
        self._ticks = 0
        # what is known beside the images
        self.asked = self.driven = 0.0
        self.pose: Optional[Tuple[float, float, float]] = None
        self.scan = _NO_SCAN

    def __enter__(self) -> 'Film':
        return self

    def __exit__(self, kind: Optional[type], *_: Any) -> None:
        if kind is not None:
            self._writer.cancel()

    def add(self, time_s: float, image: np.ndarray, encoding: str) -> None:
        """Add an image at a time since the first one, in s.

        encoding: one of areas.ENCODINGS. The pictures until then show the image before it.
        """
        self._write_until(time_s)
        areas_px: List[int] = self._extractor.measure(image, encoding)
        masked = [self._extractor.masked(number) for number in self._numbers]
        self._drawn = self._picture.draw(FilmState(
            time_s, self._extractor.bgr(), masked, areas_px, self.pose, self.scan, self.asked,
            self.driven))

    def close(self, time_s: float) -> None:
        """Complete the film, which ends at this time in s."""
        self._write_until(max(time_s, (self._ticks + 1) / RATE_HZ))
        self._writer.close()

    def _write_until(self, time_s: float) -> None:
        while self._drawn is not None and self._ticks < round(time_s * RATE_HZ):
            self._writer.write(self._drawn)
            self._ticks += 1


class FilmRecorder(Recorder):
    """Makes a film of a replay."""

    def __init__(self, film: Film):
        self._film = film

    def on_frame(self, result: FrameResult) -> None:
        motion, film = result.motion, self._film
        film.pose = float(motion.position[0]), float(motion.position[1]), motion.yaw
        film.driven = float(motion.linear[0])
        film.add(result.time_ns / SECOND_NS, result.frame.image, result.frame.encoding)

    def on_command(self, sent: CommandSent) -> None:
        self._film.asked = sent.command[0]
