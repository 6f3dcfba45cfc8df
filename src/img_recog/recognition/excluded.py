"""How many pixels each bound of a color excludes."""
from typing import List, Sequence, Tuple

import numpy as np

from img_recog.recognition.areas import ColorExtractor, to_hsv
from img_recog.recognition.recognition_settings import RecognitionSettings


def lines(extractor: ColorExtractor, areas_px: Sequence[int], settings: RecognitionSettings
          ) -> List[str]:
    """Return a line for each color of the last measured image.

    It has the area, its limit, and for each bound the pixels that are not counted because of it
    alone. areas_px: returned by that measurement; settings: those of the extractor.
    """
    image = extractor.bgr()
    rows, columns = settings.region((image.shape[0], image.shape[1]))
    part = image[rows, columns]
    # OpenCV rejects an image without pixels, as when the region is outside of the image
    hsv = to_hsv(part, 'bgr8') if part.size else part
    found = []
    for color, area_px in zip(settings.colors, areas_px):
        hue, saturation, value = (_within(hsv[..., channel], bounds) for channel, bounds in
                                  enumerate((color.hue, color.saturation, color.value)))
        hues = hsv[..., 0][~hue & saturation & value]
        others_px = np.count_nonzero(hue & saturation & value) - area_px
        found.append(
            '{}: {} px, {} the limit of {} px; out of bounds only by hue: {} px{}, only by '
            'saturation: {} px, only by value: {} px{}'.format(
                color.name, area_px, 'above' if area_px > color.area_limit_px else 'not above',
                color.area_limit_px, hues.size,
                ' (most at {})'.format(np.bincount(hues).argmax()) if hues.size else '',
                np.count_nonzero(hue & ~saturation & value),
                np.count_nonzero(hue & saturation & ~value),
                '; in too small groups or outside of its rows and columns: {} px'.format(
                    others_px) if others_px else ''))
    return found


def _within(plane: np.ndarray, bounds: Tuple[int, int]) -> np.ndarray:
    """Return where a plane is within bounds, both included; a low above high wraps through 0."""
    low, high = bounds
    if low > high:
        return (plane >= low) | (plane <= high)
    return (plane >= low) & (plane <= high)
