"""Counts of the pixels that pass each bound of a color, for the tuning picture."""
from typing import List, NamedTuple, Optional, Tuple

import cv2
import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.settings import Color, RecognitionSettings

HUES, LEVELS = 181, 256         # number of values allowed as bounds of H, and of S and V


class Histogram(NamedTuple):
    """Number of pixels for each value of a plane of the HSV image, int of shape (181 or 256,).

    all_px: all pixels; passing_px: those that are within the color's bounds of the other planes.
    """

    all_px: np.ndarray
    passing_px: np.ndarray


class ColorStatistics(NamedTuple):
    """The pixels of the region of interest compared with the bounds of one color.

    area_px: as the node counts them; in_bounds_px: also those in blobs that are too small.
    saturation, value: of the pixels whose hue is within its bounds.
    missed_px: number of pixels that are outside of one bound only: of hue, saturation, value.
    missed_hue: the most frequent hue of those that miss only the hue, None if there are none.
    """

    area_px: int
    in_bounds_px: int
    saturation: Histogram
    value: Histogram
    missed_px: Tuple[int, int, int]
    missed_hue: Optional[int]


class FrameStatistics(NamedTuple):
    """The pixels of the region of interest compared with the bounds of all colors.

    hue: of all pixels; passing are those with saturation and value within the bounds of a color.
    """

    hue: Histogram
    colors: List[ColorStatistics]


def frame_statistics(extractor: ColorExtractor, areas_px: List[int],
                     settings: RecognitionSettings) -> FrameStatistics:
    """Return the statistics of the last image measured by `extractor`.

    areas_px: returned by that measurement; settings: those of the extractor.
    """
    image = extractor.bgr()
    height, width = image.shape[:2]
    rows, columns = settings.region((height, width))
    part = image[rows, columns]
    # OpenCV rejects an image without pixels, as when the region is outside of the image
    hsv = cv2.cvtColor(np.ascontiguousarray(part), cv2.COLOR_BGR2HSV) if part.size else part
    passing, colors = np.zeros(hsv.shape[:2], bool), []
    for color, area_px in zip(settings.colors, areas_px):
        colors.append(color_statistics(hsv, color, area_px))
        passing |= (within(hsv[..., 1], color.saturation) & within(hsv[..., 2], color.value))
    return FrameStatistics(histogram(hsv[..., 0], HUES, np.ones_like(passing), passing), colors)


def color_statistics(hsv: np.ndarray, color: Color, area_px: int) -> ColorStatistics:
    """Return the statistics of one color.

    hsv: uint8 of shape (height, width, 3) on OpenCV's scale (H 0-180, S and V 0-255).
    area_px: as the node counts it.
    """
    hue, saturation, value = (
        within(hsv[..., channel], bounds)
        for channel, bounds in enumerate((color.hue, color.saturation, color.value)))
    misses_hue = ~hue & saturation & value
    misses_saturation, misses_value = hue & ~saturation & value, hue & saturation & ~value
    missed_hues = hsv[..., 0][misses_hue]
    return ColorStatistics(
        area_px, int(np.count_nonzero(hue & saturation & value)),
        histogram(hsv[..., 1], LEVELS, hue, value),
        histogram(hsv[..., 2], LEVELS, hue, saturation),
        (int(np.count_nonzero(misses_hue)), int(np.count_nonzero(misses_saturation)),
         int(np.count_nonzero(misses_value))),
        int(np.bincount(missed_hues).argmax()) if missed_hues.size else None)


def histogram(plane: np.ndarray, length: int, counted: np.ndarray,
              passing: np.ndarray) -> Histogram:
    """Count the values of a plane, uint8 of shape (height, width).

    length: of the histogram; all values are smaller.
    counted, passing: bool of the same shape: the pixels to count, and those that pass.
    """
    return Histogram(np.bincount(plane[counted], minlength=length),
                     np.bincount(plane[counted & passing], minlength=length))


def within(plane: np.ndarray, bounds: Tuple[int, int]) -> np.ndarray:
    """Return where a plane is within bounds, both included; a low above high wraps through 0."""
    low, high = bounds
    if low > high:
        return (plane >= low) | (plane <= high)
    return (plane >= low) & (plane <= high)


def spans(bounds: Tuple[int, int]) -> List[Tuple[int, int]]:
    """Return a range of hues as one span, or as two if it wraps through 0; all ends included."""
    low, high = bounds
    return [(low, high)] if low <= high else [(low, HUES - 1), (0, high)]
