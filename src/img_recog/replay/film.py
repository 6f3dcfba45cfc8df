"""A film of the system: camera, masked images, map and charts side by side."""
import contextlib
import os
from fractions import Fraction
from typing import IO, Any, Iterator, List, Sequence

import av
import numpy as np

from img_recog.camera.decoder import FFmpegError    # FFmpeg prints no lines then
from img_recog.errors import UserError, one_line
from img_recog.files import DISK_ERRORS
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.replay.chain import SECOND_NS, CommandSent, FrameResult, Recorder
from img_recog.replay.film_picture import HEIGHT, WIDTH, FilmPicture

RATE_HZ = 30
_FORMAT = 'yuv420p'
# by BT.601, which players do not assume of HD
_OPTIONS = {'preset': 'veryfast', 'crf': '20', 'colorspace': 'smpte170m'}
_ADVICE = 'see whether PyAV has the encoder libx264: av.codec.Codec("libx264", "w")'


class Film:
    """Adds images in the order of time; a film has RATE_HZ pictures a second.

    It is H.264 in an MP4 file, which browsers and all players show.
    picture: to set what is known beside the images.
    """

    def __init__(self, file: IO[bytes], settings: RecognitionSettings,
                 outlines: Sequence[np.ndarray]):
        """Start a film in an empty file.

        settings: of the colors. outlines: (corners, 2) in m of what stands in the world.
        This and all methods raise OSError with the name of the file if the disk is full or the
        like, and UserError if FFmpeg cannot encode.
        """
        self._extractor = ColorExtractor(settings)
        self._numbers = range(len(settings.colors))
        self.picture = FilmPicture(settings.colors, outlines)
        self._file_name = file.name
        self._drawn: Any = None         # the newest picture
        self._ticks = 0
        with self._encoding():
            self._container: Any = av.open('file:' + os.path.abspath(file.name), 'w', format='mp4',
                                           options={'movflags': '+faststart'})
            self._stream = self._container.add_stream('libx264', RATE_HZ, options=_OPTIONS)
            self._stream.width, self._stream.height = WIDTH, HEIGHT
            self._stream.pix_fmt = _FORMAT
            self._stream.codec_context.thread_type = 'FRAME'

    def __enter__(self) -> 'Film':
        return self

    def __exit__(self, *_: Any) -> None:
        with contextlib.suppress(OSError, UserError), self._encoding():
            self._container.close()

    def add(self, time_s: float, image: np.ndarray, encoding: str) -> None:
        """Add an image at a time since the first one, in s.

        encoding: one of areas.ENCODINGS. The pictures until then show the image before it.
        """
        self._write_until(time_s)
        areas_px: List[int] = self._extractor.measure(image, encoding)
        masked = [self._extractor.masked(number) for number in self._numbers]
        picture = self.picture.draw(time_s, self._extractor.bgr(), masked, areas_px)
        self._drawn = av.VideoFrame.from_ndarray(picture, 'bgr24').reformat(format=_FORMAT)

    def close(self, time_s: float) -> None:
        """Complete the film, which ends at this time in s."""
        self._write_until(max(time_s, (self._ticks + 1) / RATE_HZ))
        with self._encoding():
            self._container.mux(self._stream.encode(None))
            self._container.close()

    def _write_until(self, time_s: float) -> None:
        while self._drawn is not None and self._ticks < round(time_s * RATE_HZ):
            self._drawn.pts, self._drawn.time_base = self._ticks, Fraction(1, RATE_HZ)
            with self._encoding():
                self._container.mux(self._stream.encode(self._drawn))
            self._ticks += 1

    @contextlib.contextmanager
    def _encoding(self) -> Iterator[None]:
        try:
            yield
        except (FFmpegError, ValueError) as error:      # the latter: there is no such encoder
            number = getattr(error, 'errno', 0)
            if number in DISK_ERRORS:
                raise OSError(number, os.strerror(number), self._file_name)
            raise UserError('cannot encode the film: {}'.format(one_line(error)), _ADVICE)


class FilmRecorder(Recorder):
    """Makes a film of a replay."""

    def __init__(self, film: Film):
        self._film = film

    def on_frame(self, result: FrameResult) -> None:
        motion, picture = result.motion, self._film.picture
        picture.pose = float(motion.position[0]), float(motion.position[1]), motion.yaw
        picture.driven = float(motion.linear[0])
        self._film.add(result.time_ns / SECOND_NS, result.frame.image, result.frame.encoding)

    def on_command(self, sent: CommandSent) -> None:
        self._film.picture.asked = sent.command[0]
