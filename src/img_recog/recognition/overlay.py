"""Draws the result of the recognition into the image."""
from typing import Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command
from img_recog.recognition.recognition_settings import Color

_FONT, _WHITE, _BLACK = cv2.FONT_HERSHEY_SIMPLEX, (255, 255, 255), (0, 0, 0)
_Bgr = Tuple[int, ...]


def draw(extractor: ColorExtractor, colors: Sequence[Color], areas_px: Sequence[int],
         commands: Sequence[Command]) -> np.ndarray:
    """Return a copy of the last measured image with the result of its recognition.

    The copy is bgr8, uint8 of shape (height, width, 3). Each color has an outline in that color,
    a cross at its centroid, and its area and area limit as text. Below are the commands, in the
    order in which they are published.
    """
    image = extractor.bgr().copy()
    scale = max(0.4, len(image) / 900.0)
    for number, (color, area_px) in enumerate(zip(colors, areas_px)):
        line_color = bright_bgr(color)
        contours, _ = cv2.findContours(extractor.mask(number), cv2.RETR_EXTERNAL,
                                       cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(image, contours, -1, _WHITE, 3)
        cv2.drawContours(image, contours, -1, line_color, 1)
        centroid = extractor.centroid(number)
        if centroid is not None:
            position = tuple(int(round(value)) for value in centroid)
            cv2.drawMarker(image, position, _BLACK, cv2.MARKER_CROSS, int(40 * scale), 3)
            cv2.drawMarker(image, position, _WHITE, cv2.MARKER_CROSS, int(40 * scale), 1)
        sign = '>' if area_px > color.area_limit_px else '<='
        _write(image, '{}: {} px {} {}'.format(color.name, area_px, sign, color.area_limit_px),
               number, scale, line_color)
    for number, command in enumerate(commands):
        _write(image, 'command: {:g} m/s, {:g} rad/s'.format(*command), len(colors) + number,
               scale, _WHITE)
    return image


def bright_bgr(color: Color) -> _Bgr:
    """Return the middle of a color's range of hues as a bright BGR color.

    >>> bright_bgr(Color('blue', (110, 130), (0, 255), (0, 255), 0, 0.0, 0.0))
    (255, 35, 35)
    """
    pixel = cv2.cvtColor(np.array([[[color.middle_hue, 220, 255]]], np.uint8), cv2.COLOR_HSV2BGR)
    return tuple(int(value) for value in pixel[0, 0])


def _write(image: np.ndarray, text: str, line: int, scale: float, text_color: _Bgr) -> None:
    position = int(10 * scale), int((line + 1) * 34 * scale)
    cv2.putText(image, text, position, _FONT, scale, _BLACK, max(2, int(5 * scale)), cv2.LINE_AA)
    cv2.putText(image, text, position, _FONT, scale, text_color, max(1, int(1.5 * scale)),
                cv2.LINE_AA)
