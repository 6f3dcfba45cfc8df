"""A film of the system: camera, masked images, map and charts side by side, encoded by ffmpeg."""
import contextlib
import errno
import io
import os
import shutil
import signal
import subprocess
import tempfile
from typing import Any, List, Optional, Sequence

import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.files import DISK_ERRORS
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.settings import RecognitionSettings
from img_recog.replay.chain import SECOND_NS, CommandSent, FrameResult, Recorder
from img_recog.replay.film_picture import HEIGHT, WIDTH, FilmPicture

RATE_HZ = 30
_END_TIMEOUT_S = 60.0
_ADVICE = 'install the package ffmpeg'
_ENCODER_ADVICE = 'see whether ffmpeg works and has the encoder libx264: ffmpeg -encoders'


class Film:
    """Adds images in the order of time; a film has RATE_HZ pictures a second.

    picture: to set what is known beside the images.
    """

    def __init__(self, file: io.BufferedRandom, settings: RecognitionSettings,
                 outlines: Sequence[np.ndarray], path: str = ''):
        """Start a film in an open file.

        settings: of the colors. outlines: (corners, 2) in m of what stands in the world.
        path: of the film in messages, if the file has another name until it is complete.
        Raises UserError if there is no ffmpeg.
        """
        self._extractor = ColorExtractor(settings)
        self._numbers = range(len(settings.colors))
        self.picture = FilmPicture(settings.colors, outlines)
        self._writer = FilmWriter(file, WIDTH, HEIGHT, RATE_HZ, path)
        self._drawn: Optional[np.ndarray] = None
        self._ticks = 0

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
        self._drawn = self.picture.draw(time_s, self._extractor.bgr(), masked, areas_px)

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
        motion, picture = result.motion, self._film.picture
        picture.pose = float(motion.position[0]), float(motion.position[1]), motion.yaw
        picture.driven = float(motion.linear[0])
        self._film.add(result.time_ns / SECOND_NS, result.frame.image, result.frame.encoding)

    def on_command(self, sent: CommandSent) -> None:
        self._film.picture.asked = sent.command[0]


class FilmWriter:
    """Encodes pictures as H.264 in an MP4 file, which browsers and all players show.

    OpenCV's own writer has no codec that browsers show and that is fast.
    """

    def __init__(self, file: io.BufferedRandom, width: int, height: int, rate_hz: float,
                 path: str = ''):
        """Start; file: where to write, which is empty. width and height are even numbers.

        path: of the film in messages, if the file has another name until it is complete.
        Raises UserError if there is no ffmpeg.
        """
        self._name, self._path = file.name, path or str(file.name)
        program = shutil.which('ffmpeg')
        if program is None:
            raise UserError('cannot write {}: there is no program ffmpeg'.format(self._path),
                            _ADVICE)
        self._errors = tempfile.TemporaryFile()
        descriptor = file.fileno()
        self._inherited = '/dev/fd/{}'.format(descriptor)
        self._process: subprocess.Popen = subprocess.Popen(
            [program, '-loglevel', 'error', '-y', '-f', 'rawvideo', '-pix_fmt', 'bgr24',
             '-video_size', '{}x{}'.format(width, height), '-framerate', '{:.6f}'.format(rate_hz),
             '-i', '-', '-c:v', 'libx264', '-preset', 'veryfast', '-crf', '20', '-pix_fmt',
             # by BT.601, which players do not assume of HD
             'yuv420p', '-colorspace', 'smpte170m', '-movflags', '+faststart', '-f', 'mp4',
             self._inherited],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._errors,
            pass_fds=(descriptor,))
        self._input: Any = self._process.stdin

    def write(self, picture: np.ndarray) -> None:
        """Add a picture (height, width, 3), bgr8.

        Raises UserError if ffmpeg has ended, OSError with the name of the file if the disk is
        full or the like.
        """
        try:
            self._input.write(np.ascontiguousarray(picture).data)
        except OSError:
            raise self._failure()

    def close(self) -> None:
        """Complete the file; raise UserError or OSError, as `write` does, if that fails."""
        with contextlib.suppress(OSError):
            self._input.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_END_TIMEOUT_S)
        # ffmpeg 4 also ends with 0 when it cannot write the end of the file
        if self._process.returncode != 0 or self._disk_error():
            raise self._failure()

    def cancel(self) -> None:
        """End ffmpeg, if it still runs."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()

    def _failure(self) -> Exception:
        self.cancel()
        number = self._disk_error()
        if number:
            return OSError(number, os.strerror(number), self._name)
        # it knows the file only by its descriptor
        text = one_line(self._error_text().replace(self._inherited, self._path)
                        or 'it has ended with {}'.format(self._process.returncode))
        return UserError('cannot write {}: ffmpeg: {}'.format(self._path, text), _ENCODER_ADVICE)

    def _disk_error(self) -> int:
        """Return the number of the error of the disk that has ended ffmpeg; 0 if none has."""
        if self._process.returncode == -signal.SIGXFSZ:     # ulimit -f
            return errno.EFBIG
        text = self._error_text()
        return next((number for number in DISK_ERRORS if os.strerror(number) in text), 0)

    def _error_text(self) -> str:
        self._errors.seek(0)
        return self._errors.read().decode(errors='replace')
