"""Outputs of the tuning picture: a file, text on the terminal, and a window."""
import functools
import os
import sys
from typing import List, Optional, Tuple

import numpy as np
from matplotlib.figure import Figure

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.nodes.tune_colors.window import PictureWindow, WindowError
from img_recog.recognition import tuning_picture
from img_recog.recognition.settings import RecognitionSettings

_ADVICE = 'set --output to a path that can be written'


class PictureOutput:
    """Draws the tuning picture, writes it to a file and shows it in a window.

    window: the open window, None if there is none.
    """

    def __init__(self, path: str, wants_window: bool):
        self._path, self._wants_window = path, wants_window
        self._figure = Figure()
        self.window: Optional[PictureWindow] = None

    def begin(self, image: np.ndarray, settings: RecognitionSettings) -> None:
        """Write the first picture, print the area of each color, and open the window.

        image: bgr8, uint8 of shape (height, width, 3).
        """
        areas_px = self.draw(image, settings)
        self.save()
        _print_lines(*('{}; {}'.format(tuning_picture.verdict(color, area_px),
                                       tuning_picture.bounds(color))
                       for color, area_px in zip(settings.colors, areas_px)), self._path)
        if self._wants_window and os.environ.get('DISPLAY'):
            try:
                self.window = PictureWindow('tune_colors', *self._size_px())
            except WindowError as error:
                _print_lines('{}; the picture is only in the file'.format(error))
        self._show()

    def draw(self, image: np.ndarray, settings: RecognitionSettings) -> List[int]:
        """Draw the picture of an image, bgr8; return the area of each color in pixels."""
        self._figure, areas_px = tuning_picture.draw(image, settings)
        self._show()
        return areas_px

    def save(self) -> None:
        """Write the picture atomically; raise UserError if that fails."""
        try:
            with files.atomic_write([self._path], _ADVICE) as (file,):
                self._figure.savefig(file, format='png', dpi=tuning_picture.DPI)
        except OSError as error:        # while writing, as when the disk is full
            raise UserError('cannot write {}: {}'.format(self._path, one_line(error)), _ADVICE)

    def _show(self) -> None:
        if self.window is not None:
            self.window.show(functools.partial(tuning_picture.pixels, self._figure))

    def _size_px(self) -> Tuple[int, int]:
        width_in, height_in = self._figure.get_size_inches()
        return int(width_in * tuning_picture.DPI), int(height_in * tuning_picture.DPI)


def _print_lines(*lines: str) -> None:
    sys.stdout.write('\n'.join(lines) + '\n')
    sys.stdout.flush()
