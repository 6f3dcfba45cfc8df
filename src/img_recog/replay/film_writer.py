"""Writes a film by ffmpeg."""
import contextlib
import io
import shutil
import subprocess
import tempfile
from typing import Any, Optional

import numpy as np

from img_recog.errors import UserError, one_line

_END_TIMEOUT_S = 60.0
_ADVICE = 'install the package ffmpeg'


class FilmWriter:
    """Encodes pictures as H.264 in an MP4 file, which browsers and all players show.

    OpenCV's own writer has no codec that browsers show and that is fast.
    """

    def __init__(self, file: io.BufferedRandom, width: int, height: int, rate_hz: float):
        """Start; file: where to write, which is empty. width and height are even numbers.

        Raises UserError if there is no ffmpeg.
        """
        program = shutil.which('ffmpeg')
        if program is None:
            raise UserError('cannot write a film: there is no program ffmpeg', _ADVICE)
        self._errors = tempfile.TemporaryFile()
        descriptor = file.fileno()
        self._process: subprocess.Popen = subprocess.Popen(
            [program, '-loglevel', 'error', '-y', '-f', 'rawvideo', '-pix_fmt', 'bgr24',
             '-video_size', '{}x{}'.format(width, height), '-framerate', '{:.6f}'.format(rate_hz),
             '-i', '-', '-c:v', 'libx264', '-preset', 'veryfast', '-crf', '20', '-pix_fmt',
             'yuv420p', '-movflags', '+faststart', '-f', 'mp4',
             '/dev/fd/{}'.format(descriptor)],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._errors,
            pass_fds=(descriptor,))
        self._input: Any = self._process.stdin

    def write(self, picture: np.ndarray) -> None:
        """Add a picture (height, width, 3), bgr8; raise UserError if ffmpeg has ended."""
        try:
            self._input.write(np.ascontiguousarray(picture).data)
        except OSError:
            raise self._failure()

    def close(self) -> None:
        """Complete the file; raise UserError if that fails."""
        with contextlib.suppress(OSError):
            self._input.close()
        try:
            code: Optional[int] = self._process.wait(_END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            code = None
        if code != 0:
            raise self._failure()

    def cancel(self) -> None:
        """End ffmpeg, if it still runs."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()

    def _failure(self) -> UserError:
        self.cancel()
        self._errors.seek(0)
        text = one_line(self._errors.read().decode(errors='replace') or 'it has ended')
        return UserError('cannot write the film: ffmpeg: {}'.format(text))
