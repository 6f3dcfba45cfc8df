"""Exact histograms over hue, saturation and value, one for each label of pixels."""
from typing import Any, Dict, Iterable, NamedTuple, Tuple

import cv2
import numpy as np

from img_recog.errors import UserError
from img_recog.recognition.fitting.volume import Sparse, sparse

# levels of a cell: noise and compression may move pixels to the next one
_BRIGHTNESS, _CHROMA, _LEVELS = 16, 8, 256
# of the fullest cell: where there are fewer, colors are mixed at an edge, or left by compression
_FEW = 0.03

Counts = Tuple[np.ndarray, np.ndarray]      # flat indices of bins of HSV, and the pixels in them
CHANNELS = 'hue', 'saturation', 'value'
HUES, LEVELS = 180, 256
SHAPE = HUES, LEVELS, LEVELS
# pixels that are counted at a time, which a 32 bit float of OpenCV's histogram counts one by one
_BATCH_PX = 1 << 24
_FEW_PX = 200000        # up to so many, to sort them takes less than half of the time of calcHist
_RANGES = [0, HUES, 0, LEVELS, 0, LEVELS]
UNIT = 256          # in which pixels are weighted

# Kinds of labels: pixels of a color; pixels that are not of it, or of none if it has no name; and
# pixels of frames in which it is in view somewhere.
COLOR, NOT, IN_VIEW = 'color', 'not', 'in view'


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


class Label(NamedTuple):
    """What is known of pixels: kind, name of the color, and the colors in view in their frame."""

    kind: str
    name: str
    in_view: Tuple[str, ...] = ()


class Histograms(NamedTuple):
    """The histogram of each label, and in how many frames it is."""

    pixels: Dict[Label, Sparse]
    frames: Dict[Label, int]


class Sampled(NamedTuple):
    """The pixels of a color, and those that are not of it, of SHAPE, in UNITs of a pixel.

    Pixels of the frames without the color are weighted as if there were not more of these frames
    than of those with it.
    """

    positive: Sparse
    negative: Sparse


class Counter:
    """Counts pixels of frames in histograms, exactly; the memory does not grow with the frames."""

    def __init__(self) -> None:
        self._frames: Dict[Label, int] = {}
        self._totals: Dict[Label, Sparse] = {}
        # of each label: pixels that wait to be counted, and how many there are
        self._waiting: Dict[Label, np.ndarray] = {}
        self._waiting_px: Dict[Label, int] = {}

    def add_frame(self, parts: Iterable[Tuple[Label, np.ndarray]]) -> None:
        """Count the labeled pixels of a frame, as FrameLabels.parts gives them.

        They are on OpenCV's 8-bit HSV scale, uint8 of shape (..., 3); labels may be repeated.
        """
        labels = set()
        for label, pixels in parts:
            if pixels.size:
                labels.add(label)
                self._add(label, pixels)
        for label in labels:
            self._frames[label] = self._frames.get(label, 0) + 1

    def _add(self, label: Label, pixels: np.ndarray) -> None:
        if label not in self._waiting:
            self._waiting[label], self._waiting_px[label] = np.empty((_BATCH_PX, 3), np.uint8), 0
        pixels = pixels.reshape(-1, 3)
        while len(pixels):
            start = self._waiting_px[label]
            part = pixels[:_BATCH_PX - start]
            self._waiting[label][start:start + len(part)] = part
            self._waiting_px[label] += len(part)
            pixels = pixels[len(part):]
            if self._waiting_px[label] == _BATCH_PX:
                self._count(label)

    def add_result(self, histograms: Histograms) -> None:
        """Add what another counter has counted; the order makes no difference."""
        for label, histogram in histograms.pixels.items():
            _add_to(self._totals, label, histogram)
        for label, frames in histograms.frames.items():
            self._frames[label] = self._frames.get(label, 0) + frames

    def result(self) -> Histograms:
        """Return what was counted, in the order of the labels."""
        for label, count in self._waiting_px.items():
            if count:
                self._count(label)
        return Histograms(dict(sorted(self._totals.items())), dict(sorted(self._frames.items())))

    def _count(self, label: Label) -> None:
        pixels = self._waiting[label][:self._waiting_px[label], np.newaxis]
        self._waiting_px[label] = 0
        # calcHist takes long to clear and convert its 12 million bins, so it gets many pixels
        found = (_sorted(pixels[:, 0]) if len(pixels) <= _FEW_PX else
                 sparse(cv2.calcHist([pixels], [0, 1, 2], None, SHAPE, _RANGES)))
        _add_to(self._totals, label, found)


def _sorted(pixels: np.ndarray) -> Sparse:
    """Return the histogram of pixels of shape (n, 3)."""
    indices, counts = np.unique(np.ravel_multi_index(tuple(pixels.T), SHAPE), return_counts=True)
    return Sparse(indices.astype(np.uint32), counts)


def _add_to(sums: Dict[Any, Sparse], key: Any, histogram: Sparse) -> None:
    sums[key] = _sum([histogram, sums[key]]) if key in sums else histogram


def _sum(histograms: Iterable[Sparse]) -> Sparse:
    histograms = [each for each in histograms if len(each.counts)]
    if not histograms:
        return Sparse(np.zeros(0, np.uint32), np.zeros(0, np.int64))
    indices = np.concatenate([each.indices for each in histograms])
    order = indices.argsort(kind='stable')
    indices = indices[order]
    starts = np.flatnonzero(np.diff(indices, prepend=indices[:1] + 1))
    return Sparse(indices[starts], np.add.reduceat(
        np.concatenate([each.counts for each in histograms])[order], starts))


def is_by_times(histograms: Histograms, color: str) -> bool:
    """Return whether only times are known in which a color is in view."""
    kinds = {label.kind for label in histograms.pixels if label.name == color}
    return IN_VIEW in kinds and COLOR not in kinds


def of_color(histograms: Histograms, color: str, uses_brightness: bool = True) -> Sampled:
    """Return the pixels of a color, and those that are not of it.

    If no pixel is labeled with the color, its pixels are estimated, as `shares` says, also for
    uses_brightness. Raises UserError if the times do not tell it from other colors.
    """
    pixels = histograms.pixels
    own = [_scaled(found, UNIT) for label, found in pixels.items() if label[:2] == (COLOR, color)]
    with_color, without = (_frames(histograms, color, is_in_view) for is_in_view in (True, False))
    weight = max(1, round(UNIT * min(1.0, with_color / max(1, without))))
    negative = [_scaled(found, UNIT if color in label.in_view else weight)
                for label, found in pixels.items()
                if label.kind == NOT and label.name in ('', color)
                or label.kind == COLOR and label.name != color]
    if is_by_times(histograms, color):
        seen, unseen = _compared(pixels, color)
        in_view_px = sum(pixels[label].counts.sum() for label in pixels
                         if label[:2] == (IN_VIEW, color))
        weighted = UNIT * in_view_px / seen.counts.sum() * seen.counts
        for found, share in zip((own, negative), shares(seen, unseen, uses_brightness)):
            counts = np.rint(weighted * share).astype(np.int64)
            found.append(Sparse(seen.indices[counts > 0], counts[counts > 0]))
    return Sampled(_sum(own), _sum(negative))


def _compared(pixels: Dict[Label, Sparse], color: str) -> Tuple[Sparse, Sparse]:
    """Return the pixels of frames with a color, and of as many without it.

    They have the same others of the colors in view: else these would be taken for it, or it for
    them. Raises UserError if there are no such frames.
    """
    seen: Dict[Tuple[str, ...], Sparse] = {}
    unseen: Dict[Tuple[str, ...], Sparse] = {}
    for label, found in pixels.items():
        others = tuple(name for name in label.in_view if name != color)
        if label[:2] == (IN_VIEW, color):
            _add_to(seen, others, found)
        elif label.kind == NOT and label.name in ('', color) and others == label.in_view:
            _add_to(unseen, others, found)
    if not unseen:
        raise UserError('there is no time without {}'.format(color),
                        'add one: not_in_view: [start, end]')
    if () in seen and () not in unseen:     # no other color can be taken for it
        unseen[()] = _sum(unseen.values())
    pairs = [(seen[others], unseen[others]) for others in seen if others in unseen]
    if not pairs:
        raise UserError('whenever {0} is in view, {1} is too, and never alone: nothing tells them '
                        'apart'.format(color, ' or '.join(map(' and '.join, seen))),
                        'add a time with only one of them, or mark {} in a frame'.format(color))
    return _sum(found for found, _ in pairs), _sum(
        _scaled(without, found.counts.sum() / without.counts.sum()) for found, without in pairs)


def _scaled(histogram: Sparse, factor: float) -> Sparse:
    return Sparse(histogram.indices, histogram.counts * factor)


def _frames(histograms: Histograms, color: str, is_in_view: bool) -> int:
    """Return how many frames have the color in view, or not."""
    frames: Dict[Tuple[str, ...], int] = {}
    for label, count in histograms.frames.items():
        if (color in label.in_view) == is_in_view:
            # a frame may have several labels, all with the same colors in view
            frames[label.in_view] = max(count, frames.get(label.in_view, 0))
    return sum(frames.values())
