"""What of an image passes which bound of a color: the numbers in a tuning picture."""
from typing import List, NamedTuple, Optional, Tuple

import cv2
import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.settings import Color, RecognitionSettings

HUES, LEVELS = 181, 256         # so many values are allowed as bounds of H, and of S and V


class Histogram(NamedTuple):
    """How many pixels have each value of a plane of the HSV image, int of shape (181 or 256,).

    passing_px: of these, the ones that pass the color's bounds of the other planes.
    """

    all_px: np.ndarray
    passing_px: np.ndarray


class ColorNumbers(NamedTuple):
    """How the pixels of the region of interest fare with one color.

    area_px: as the node counts them; in_bounds_px: the same without regard to the size of blobs.
    saturation, value: of the pixels with a hue within its bounds.
    missed_px: pixels outside of the bounds of hue, of saturation and of value alone.
    missed_hue: the hue that most of those have that miss by the hue, None if there are none.
    """

    area_px: int
    in_bounds_px: int
    saturation: Histogram
    value: Histogram
    missed_px: Tuple[int, int, int]
    missed_hue: Optional[int]


class FrameNumbers(NamedTuple):
    """How the pixels of the region of interest fare.

    hue: of all of them; passing are those with saturation and value within the bounds of a color.
    """

    hue: Histogram
    colors: List[ColorNumbers]


def frame_numbers(extractor: ColorExtractor, areas_px: List[int],
                  settings: RecognitionSettings) -> FrameNumbers:
    """Return the numbers of the image that `extractor` measured last, by the same settings.

    areas_px: what that measuring returned.
    """
    image = extractor.bgr()
    part = image[settings.region(image.shape[:2])]
    # OpenCV refuses an image without pixels, as a region beside the image is
    hsv = cv2.cvtColor(np.ascontiguousarray(part), cv2.COLOR_BGR2HSV) if part.size else part
    passing, colors = np.zeros(hsv.shape[:2], bool), []
    for color, area_px in zip(settings.colors, areas_px):
        colors.append(color_numbers(hsv, color, area_px))
        passing |= (within(hsv[..., 1], color.saturation) & within(hsv[..., 2], color.value))
    return FrameNumbers(histogram(hsv[..., 0], HUES, np.ones_like(passing), passing), colors)


def color_numbers(hsv: np.ndarray, color: Color, area_px: int) -> ColorNumbers:
    """Return the numbers of one color.

    hsv: uint8 of shape (height, width, 3) on OpenCV's scale (H 0-180, S and V 0-255).
    """
    hue, saturation, value = (
        within(hsv[..., channel], bounds)
        for channel, bounds in enumerate((color.hue, color.saturation, color.value)))
    missed = [~hue & saturation & value, hue & ~saturation & value, hue & saturation & ~value]
    missed_hues = hsv[..., 0][missed[0]]
    return ColorNumbers(
        area_px, int(np.count_nonzero(hue & saturation & value)),
        histogram(hsv[..., 1], LEVELS, hue, value),
        histogram(hsv[..., 2], LEVELS, hue, saturation),
        tuple(int(np.count_nonzero(each)) for each in missed),
        int(np.bincount(missed_hues).argmax()) if missed_hues.size else None)


def histogram(plane: np.ndarray, length: int, counted: np.ndarray,
              passing: np.ndarray) -> Histogram:
    """Count the values of a plane, uint8 of shape (height, width).

    length: of the histogram: no value is as large.
    counted, passing: bool of the same shape: which pixels to count, and which of these pass.
    """
    return Histogram(np.bincount(plane[counted], minlength=length),
                     np.bincount(plane[counted & passing], minlength=length))


def within(plane: np.ndarray, bounds: Tuple[int, int]) -> np.ndarray:
    """Return where a plane is from low to high, both included; low above high goes through 0."""
    low, high = bounds
    if low > high:
        return (plane >= low) | (plane <= high)
    return (plane >= low) & (plane <= high)


def spans(bounds: Tuple[int, int]) -> List[Tuple[int, int]]:
    """Return a range of hues as one span, or as two when it goes through 0; all ends included."""
    low, high = bounds
    return [(low, high)] if low <= high else [(low, HUES - 1), (0, high)]
