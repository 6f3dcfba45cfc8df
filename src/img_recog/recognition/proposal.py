"""Proposes bounds of a color from a part of an image."""
from typing import Dict

import cv2
import numpy as np

from img_recog.errors import UserError

_RADIUS_PX = 4          # of the square around the point that was chosen
_HUES = 180
_HUE_MARGIN, _LEVEL_MARGIN = 10, 60
_MIN_SATURATION, _MIN_VALUE = 40, 30


def propose_bounds(image: np.ndarray, x: float, y: float) -> Dict[str, int]:
    """Return hue, saturation and value bounds that contain the color at a point and similar ones.

    image: bgr8, uint8 of shape (height, width, 3). x, y: shares of width and height, 0 to 1.
    The bounds are on OpenCV's 8-bit scale; if hue_min is above hue_max, the hue wraps around.
    Brighter and more saturated pixels of the same hue are within them.
    Raises UserError for a part that is too gray or too dark to have a hue that is steady.

    >>> bounds = propose_bounds(np.full((20, 20, 3), (60, 25, 215), np.uint8), 0.5, 0.5)
    >>> bounds['hue_min'], bounds['hue_max'], bounds['saturation_min'], bounds['value_min']
    (164, 4, 165, 155)
    """
    height, width = image.shape[:2]
    column, row = (min(size - 1, max(0, int(share * size)))
                   for share, size in ((x, width), (y, height)))
    part = image[max(0, row - _RADIUS_PX):row + _RADIUS_PX + 1,
                 max(0, column - _RADIUS_PX):column + _RADIUS_PX + 1]
    hue, saturation, value = (plane.ravel().astype(float) for plane in
                              cv2.split(cv2.cvtColor(part, cv2.COLOR_BGR2HSV)))
    usual_saturation, usual_value = np.median(saturation), np.median(value)
    if usual_saturation < _MIN_SATURATION or usual_value < _MIN_VALUE:
        raise UserError('too gray or too dark: saturation {:.0f}, value {:.0f}, needed are {} and '
                        '{}'.format(usual_saturation, usual_value, _MIN_SATURATION, _MIN_VALUE),
                        'choose a part with a clear color')
    # hues are angles: red is near 0 and near 180
    angles = hue * (2 * np.pi / _HUES)
    middle = np.arctan2(np.sin(angles).mean(), np.cos(angles).mean()) * _HUES / (2 * np.pi)
    return {'hue_min': int(round(middle - _HUE_MARGIN)) % _HUES,
            'hue_max': int(round(middle + _HUE_MARGIN)) % _HUES,
            'saturation_min': int(max(_MIN_SATURATION, usual_saturation - _LEVEL_MARGIN)),
            'saturation_max': 255,
            'value_min': int(max(_MIN_VALUE, usual_value - _LEVEL_MARGIN)),
            'value_max': 255}
