"""The area limit and the least blob size that tell best in which frames a color is."""
from typing import Dict, List, NamedTuple, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.fitting.score import Score

# of min_blob_size, among which one is chosen; 0 keeps all
BLOB_SIZES = 0, 4, 16, 64, 256, 1024
# Areas are known to this many digits, so that the memory does not grow with the frames.
_DIGITS = 1000
TIE = 0.002         # F1 of pixels that differ by no more are equally good
_MIN_GAIN = 1.5     # a larger blob size has to make the gap between areas so much wider


class Limit(NamedTuple):
    """An area limit in pixels, with its score in frames.

    gap: by which factor the next area above it exceeds the next one below it.
    """

    area_px: int
    score: Score
    gap: float


class Areas:
    """The areas of a color in the frames in which it is in view, and in those in which it is not.
    """

    def __init__(self) -> None:
        self._counts: Tuple[Dict[int, int], Dict[int, int]] = {}, {}

    def add(self, area_px: int, is_in_view: bool) -> None:
        """Count a frame."""
        counts = self._counts[is_in_view]
        area_px = _rounded(area_px)
        counts[area_px] = counts.get(area_px, 0) + 1

    def score(self, limit_px: int) -> Score:
        """Return the score if the color is recognized in frames with a larger area."""
        unseen, seen = self._counts
        found = sum(count for area_px, count in seen.items() if area_px > limit_px)
        return Score(found, sum(count for area_px, count in unseen.items()
                                if area_px > limit_px), sum(seen.values()) - found)

    def limit(self) -> Limit:
        """Return the best limit by F1; of equally good ones, that in the widest gap.

        It is in the geometric middle of the gap: areas vary by factors, with the distance.
        """
        areas_px = sorted({0, *self._counts[0], *self._counts[1]})
        best = Limit(areas_px[-1], self.score(areas_px[-1]), 1.0)
        for below_px, above_px in zip(areas_px, areas_px[1:]):
            score, gap = self.score(below_px), above_px / (below_px + 1)
            if score.f1 and (score.f1, gap) > (best.score.f1, best.gap):
                middle_px = int(np.sqrt((below_px + 1) * above_px)) - 1
                best = Limit(max(below_px, middle_px), score, gap)
        return best


class Blobs(NamedTuple):
    """What is left of a mask without its blobs of fewer pixels, for each size; int arrays.

    areas_px: (sizes,), as in areas.py. pixels: (sizes, 3), the Score of the labeled ones.
    """

    areas_px: np.ndarray
    pixels: np.ndarray


def blobs(mask: np.ndarray, sizes: Sequence[int], is_color: np.ndarray, is_not: np.ndarray
          ) -> Blobs:
    """Return the blobs of a mask, uint8 of shape (height, width), 0 outside.

    is_color, is_not: where pixels are of the color, and where they are not, as FrameLabels.truth
    returns them.
    """
    blobs_px = found = wrong = np.zeros(0, np.int64)
    if mask.any():
        count, numbers, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
        blobs_px = stats[1:, cv2.CC_STAT_AREA]
        found, wrong = (np.bincount(numbers[np.broadcast_to(part, mask.shape)],
                                    minlength=count)[1:] for part in (is_color, is_not))
    kept = (blobs_px >= np.reshape(sizes, (-1, 1))).astype(np.int64)
    found, wrong = kept @ found, kept @ wrong
    return Blobs(kept @ blobs_px,
                 np.stack([found, wrong, np.count_nonzero(is_color) - found], axis=1))


def best_size(limits: Dict[int, List[Limit]], pixels_f1: Dict[int, float]) -> int:
    """Return the blob size by which the colors are told apart best.

    limits: for each size, the limit of each color; pixels_f1: the sum of F1 of their pixels. A
    size is chosen before a smaller one if F1 of the frames is better, or equal with a better F1 of
    the pixels, or both are equal with much wider gaps. It is not above the limits.
    """
    best = min(limits)
    for size in sorted(limits)[1:]:
        if any(size > limit.area_px for limit in limits[size]):
            continue
        f1, best_f1 = (sum(limit.score.f1 for limit in limits[each]) for each in (size, best))
        gap, best_gap = (min(limit.gap for limit in limits[each]) for each in (size, best))
        gain = pixels_f1[size] - pixels_f1[best]
        if f1 > best_f1 or f1 == best_f1 and (
                gain > TIE or gain >= -TIE and gap >= _MIN_GAIN * best_gap):
            best = size
    return best


def _rounded(area_px: int) -> int:
    """Return an area with three digits, of smaller ones all.

    >>> _rounded(123456), _rounded(321)
    (123000, 321)
    """
    step = 1
    while area_px >= _DIGITS * step:
        step *= 10
    return area_px // step * step
