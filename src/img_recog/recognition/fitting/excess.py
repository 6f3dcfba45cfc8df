"""Which pixels are of a color if only times are known in which it is in view.

Frames with the color are compared with frames without it, in cells of YCrCb: there, noise and
compression move a pixel by as many levels wherever it is. The hue of a gray one changes much more.
"""
from typing import Tuple

import cv2
import numpy as np

# levels of a cell: noise and compression may move pixels to the next one
_BRIGHTNESS, _CHROMA, _LEVELS = 16, 8, 256
# of the fullest cell: where there are fewer, colors are mixed at an edge, or left by compression
_FEW = 0.03

Counts = Tuple[np.ndarray, np.ndarray]      # flat indices of bins of HSV, and the pixels in them


def shares(seen: Counts, unseen: Counts, uses_brightness: bool) -> Tuple[np.ndarray, np.ndarray]:
    """Return which shares of the pixels in each bin of `seen` are of the color, and of others.

    Both float of shape (n,), 0 to 1. Of the rest it is not known.

    seen, unseen: of frames with and without it, with as many pixels. A cell of `seen` has as many
    pixels of other colors as the fullest one of `unseen` that is the same or next to it.
    uses_brightness: False for cells of all brightness: other light then makes no difference, but
    black, gray and white are one color.
    """
    levels = np.array([_BRIGHTNESS if uses_brightness else _LEVELS, _CHROMA, _CHROMA])
    shape = tuple(_LEVELS // levels)
    cells = [np.ravel_multi_index(tuple((_ycrcb(indices) // levels).T), shape)
             for indices, _ in (seen, unseen)]
    own, others = (np.bincount(cell, counts, np.prod(shape)).reshape(shape)
                   for cell, (_, counts) in zip(cells, (seen, unseen)))
    more = np.maximum(own - _highest_near(others), 0)
    is_few = more < _FEW * more.max()
    share = more / np.maximum(own, 1)
    return (np.where(is_few, 0, share).reshape(-1)[cells[0]],
            (1 - share).reshape(-1)[cells[0]])


def _ycrcb(indices: np.ndarray) -> np.ndarray:
    """Return the colors of bins: int of shape (n, 3)."""
    hsv = np.stack([indices >> 16, indices >> 8 & 255, indices & 255], axis=-1).astype(np.uint8)
    bgr = cv2.cvtColor(hsv[:, np.newaxis], cv2.COLOR_HSV2BGR)
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2YCrCb)[:, 0].astype(int)


def _highest_near(cells: np.ndarray) -> np.ndarray:
    """Return for each cell the largest number in it and in those around it."""
    for axis in range(cells.ndim):
        rows = np.moveaxis(cells, axis, 0)
        padded = np.concatenate([rows[:1], rows, rows[-1:]])
        cells = np.moveaxis(np.maximum.reduce([padded[:-2], rows, padded[2:]]), 0, axis)
    return cells
