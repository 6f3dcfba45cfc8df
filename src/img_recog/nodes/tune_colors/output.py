"""Where the tuning picture is shown: a file, lines of text, and a window if there is a display."""
import functools
import os
import sys
from typing import Optional

import numpy as np

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.tune_colors.window import PictureWindow, WindowError
from img_recog.recognition import tuning_picture
from img_recog.recognition.settings import RecognitionSettings


class PictureOutput:
    """Where the picture is shown: a file and perhaps a window."""

    def __init__(self, path: str, wants_window: bool):
        self._path, self._wants_window = path, wants_window
        self._figure = None
        self.window: Optional[PictureWindow] = None

    def begin(self, image: np.ndarray, settings: RecognitionSettings) -> None:
        """Write the first picture, of a bgr8 image, and tell what is in it; open the window."""
        areas_px = self.draw(image, settings)
        self.save()
        _say(*('{}; {}'.format(tuning_picture.verdict(color, area_px),
                               tuning_picture.bounds(color))
               for color, area_px in zip(settings.colors, areas_px)), self._path)
        if self._wants_window and os.environ.get('DISPLAY'):
            try:
                self.window = PictureWindow('tune_colors', *self._size_px())
            except WindowError as error:
                _say('{}; the picture is in the file'.format(error))
        self._show()

    def draw(self, image: np.ndarray, settings: RecognitionSettings) -> list:
        """Draw the picture of a bgr8 image; return the area of each color in pixels."""
        self._figure, areas_px = tuning_picture.draw(image, settings)
        self._show()
        return areas_px

    def save(self) -> None:
        """Write the picture, whole or not at all; raise UserError when it cannot be."""
        try:
            with files.atomic_write([self._path], 'set --output') as (file,):
                self._figure.savefig(file, format='png', dpi=tuning_picture.DPI)
        except OSError as error:        # while it is written, as of a disk that is full
            raise UserError('cannot write {}: {}; set --output'.format(self._path,
                                                                       error.strerror))

    def _show(self) -> None:
        if self.window is not None:
            self.window.show(functools.partial(tuning_picture.pixels, self._figure))

    def _size_px(self) -> list:
        return [int(inches * tuning_picture.DPI) for inches in self._figure.get_size_inches()]


def _say(*lines: str) -> None:
    sys.stdout.write('\n'.join(lines) + '\n')
    sys.stdout.flush()
