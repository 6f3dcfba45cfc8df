"""Masks by cv2.inRange, as a reference."""
import cv2
import numpy as np


def mask(image, color):
    """Return the mask of a color in a bgr8 image; its range of hues must not wrap around."""
    bounds = color.hue, color.saturation, color.value
    return cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV),
                       *(np.array([low_high[end] for low_high in bounds]) for end in (0, 1)))
