"""What was recognized, drawn into the image."""
from typing import Sequence

import cv2
import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command
from img_recog.recognition.settings import Color

_FONT, _WHITE, _BLACK = cv2.FONT_HERSHEY_SIMPLEX, (255, 255, 255), (0, 0, 0)


def draw(extractor: ColorExtractor, colors: Sequence[Color], areas_px: Sequence[int],
         commands: Sequence[Command]) -> np.ndarray:
    """Return the image that was measured last with what was found in it.

    bgr8, uint8 of shape (height, width, 3): the outline of each color in that color, a cross at
    its centroid, its area beside its limit, and the commands in the order in which they are sent.
    """
    image = extractor.bgr().copy()
    scale = max(0.4, len(image) / 900.0)
    for number, (color, area_px) in enumerate(zip(colors, areas_px)):
        ink = color_of(color)
        contours, _ = cv2.findContours(extractor.mask(number), cv2.RETR_EXTERNAL,
                                       cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(image, contours, -1, _WHITE, 3)
        cv2.drawContours(image, contours, -1, ink, 1)
        centroid = extractor.centroid(number)
        if centroid is not None:
            at = tuple(int(round(value)) for value in centroid)
            cv2.drawMarker(image, at, _BLACK, cv2.MARKER_CROSS, int(40 * scale), 3)
            cv2.drawMarker(image, at, _WHITE, cv2.MARKER_CROSS, int(40 * scale), 1)
        sign = '>' if area_px > color.area_limit_px else '<='
        _write(image, '{}: {} px {} {}'.format(color.name, area_px, sign, color.area_limit_px),
               number, scale, ink)
    for number, command in enumerate(commands):
        _write(image, 'command: {:g} m/s, {:g} rad/s'.format(*command), len(colors) + number,
               scale, _WHITE)
    return image


def color_of(color: Color) -> tuple:
    """Return the middle of a color's hues as a bright BGR color."""
    pixel = cv2.cvtColor(np.array([[[color.middle_hue, 220, 255]]], np.uint8), cv2.COLOR_HSV2BGR)
    return tuple(int(value) for value in pixel[0, 0])


def _write(image: np.ndarray, text: str, line: int, scale: float, ink: tuple) -> None:
    at = int(10 * scale), int((line + 1) * 34 * scale)
    cv2.putText(image, text, at, _FONT, scale, _BLACK, max(2, int(5 * scale)), cv2.LINE_AA)
    cv2.putText(image, text, at, _FONT, scale, ink, max(1, int(1.5 * scale)), cv2.LINE_AA)
