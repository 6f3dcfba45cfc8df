"""Conversion of OpenCV's images to the encodings that are published."""
import cv2
import numpy as np


def convert(image: np.ndarray, encoding: str) -> np.ndarray:
    """Return an image from OpenCV, bgr8 or mono8, in the encoding to publish.

    encoding: `rgb8` or `mono8`.
    """
    if encoding == 'mono8':
        return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return cv2.cvtColor(image, cv2.COLOR_GRAY2RGB if image.ndim == 2 else cv2.COLOR_BGR2RGB)
