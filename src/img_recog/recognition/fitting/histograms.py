"""Exact histograms over hue, saturation and value, one for each label of pixels."""
from typing import Dict, Iterator, List, Mapping, NamedTuple, Tuple

import cv2
import numpy as np

HUES, LEVELS = 180, 256
SHAPE = HUES, LEVELS, LEVELS
# pixels that are counted at a time: far fewer than a 32 bit float can count one by one
_BATCH_PX = 1 << 22
_RANGES = [0, HUES, 0, LEVELS, 0, LEVELS]

# Labels of pixels, with the name of a color: pixels of that color; pixels that are not of it; and
# pixels of frames in which it is in view somewhere. NO_COLOR: pixels that are of no color.
COLOR, NOT, IN_VIEW = 'color', 'not', 'in view'
Label = Tuple[str, str]
NO_COLOR: Label = (NOT, '')


class Sparse(NamedTuple):
    """The bins of a histogram that are not empty: their flat indices in order, and counts."""

    indices: np.ndarray
    counts: np.ndarray


class Counter:
    """Counts pixels of frames in histograms; the memory is that of one histogram a label."""

    def __init__(self) -> None:
        self._totals: Dict[Label, np.ndarray] = {}
        self._waiting: Dict[Label, List[np.ndarray]] = {}
        self._waiting_px: Dict[Label, int] = {}

    def add(self, label: Label, pixels: np.ndarray) -> None:
        """Count pixels: on OpenCV's 8-bit HSV scale, uint8 of shape (..., 3)."""
        pixels = pixels.reshape(-1, 1, 3)
        for start in range(0, len(pixels), _BATCH_PX):
            part = pixels[start:start + _BATCH_PX]
            if self._waiting_px.get(label, 0) + len(part) > _BATCH_PX:
                self._count(label)
            self._waiting.setdefault(label, []).append(part)
            self._waiting_px[label] = self._waiting_px.get(label, 0) + len(part)

    def result(self) -> Dict[Label, Sparse]:
        """Return the histogram of each label, in the order of the labels."""
        for label in list(self._waiting):
            self._count(label)
        return {label: sparse(self._totals[label]) for label in sorted(self._totals)}

    def _count(self, label: Label) -> None:
        pixels = np.concatenate(self._waiting.pop(label))
        self._waiting_px[label] = 0
        if not len(pixels):
            return
        total = self._totals.setdefault(label, np.zeros(SHAPE, np.int64))
        # calcHist takes long to clear and convert its 12 million bins, so it gets many pixels
        np.add(total, cv2.calcHist([pixels], [0, 1, 2], None, SHAPE, _RANGES), out=total,
               casting='unsafe')


def sparse(counts: np.ndarray) -> Sparse:
    """Return the bins of a histogram, of SHAPE, that are not empty."""
    indices = np.flatnonzero(counts)
    return Sparse(indices.astype(np.uint32), counts.reshape(-1)[indices])


def dense(histogram: Sparse) -> np.ndarray:
    """Return all bins of a histogram: int64 of SHAPE."""
    counts = np.zeros(SHAPE, np.int64)
    counts.reshape(-1)[histogram.indices] = histogram.counts
    return counts


def merged(first: Mapping[Label, Sparse], second: Mapping[Label, Sparse]) -> Dict[Label, Sparse]:
    """Return the sum of two results; the order makes no difference."""
    result = {}
    for label in sorted({*first, *second}):
        if label in first and label in second:
            counts = dense(first[label])
            counts.reshape(-1)[second[label].indices] += second[label].counts
            result[label] = sparse(counts)
        else:
            result[label] = (first if label in first else second)[label]
    return result


def of_color(histograms: Mapping[Label, Sparse], color: str) -> Tuple[np.ndarray, np.ndarray]:
    """Return the histogram of the pixels of a color, and of those that are not of it: of SHAPE.

    If no pixel is labeled with the color, its pixels are estimated: those of the frames in which it
    is in view, less what frames without it have, as many times as there are more pixels.
    """
    negative = np.zeros(SHAPE, np.int64)
    for label in _negatives(histograms, color):
        counts = histograms[label]
        negative.reshape(-1)[counts.indices] += counts.counts
    if (COLOR, color) in histograms:
        return dense(histograms[COLOR, color]), negative
    if (IN_VIEW, color) not in histograms:
        return np.zeros(SHAPE, np.int64), negative
    seen = dense(histograms[IN_VIEW, color])
    ratio = seen.sum() / max(1, negative.sum())
    return np.maximum(seen - np.rint(negative * ratio).astype(np.int64), 0), negative


def _negatives(histograms: Mapping[Label, Sparse], color: str) -> Iterator[Label]:
    for kind, name in histograms:
        if (kind == NOT and name in ('', color)) or (kind == COLOR and name != color):
            yield kind, name
