"""Masks as one writes them first, to compare with."""
import cv2
import numpy as np


def mask(image, color):
    """Return where a bgr8 image is of a color whose hue does not go through 0: 255 there."""
    bounds = color.hue, color.saturation, color.value
    return cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV),
                       *(np.array([each[end] for each in bounds]) for end in (0, 1)))
