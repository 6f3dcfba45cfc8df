"""Colour ranges to areas and masked images."""
from typing import List, NamedTuple, Sequence

import cv2
import numpy as np

from img_recog.recognition.settings import ColorRange


class ColorArea(NamedTuple):
    """What was found of one colour in a frame.

    name: of the colour; area_px: pixels inside the range; image: bgr8, uint8 of the frame's
    shape (height, width, 3), with every pixel outside the range black.
    """

    name: str
    area_px: int
    image: np.ndarray


def extract(image: np.ndarray, colors: Sequence[ColorRange]) -> List[ColorArea]:
    """Measure each colour in a bgr8 image, uint8 of shape (height, width, 3).

    The ranges are independent: a pixel may belong to several. Returns one ColorArea a colour,
    in the order given.
    """
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    areas = []
    for color in colors:
        mask = cv2.inRange(hsv, np.array(color.lower), np.array(color.upper))
        masked = cv2.bitwise_and(image, image, mask=mask)
        areas.append(ColorArea(color.name, cv2.countNonZero(mask), masked))
    return areas
