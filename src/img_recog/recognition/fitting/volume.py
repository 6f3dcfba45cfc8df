"""The summed volume table of a histogram over hue, saturation and value."""
from typing import NamedTuple, Tuple

import numpy as np


class Box(NamedTuple):
    """A range of HSV: lowest and highest hue, saturation and value, both included.

    If the lowest hue is above the highest one, the range goes through 0.
    """

    hue: Tuple[int, int]
    saturation: Tuple[int, int]
    value: Tuple[int, int]


def edges_of(box: Box, hues: int) -> np.ndarray:
    """Return the edges of a box: int of shape (6,), as `SummedVolume.count` takes them.

    >>> edges_of(Box((170, 10), (100, 255), (0, 255)), 180)
    array([170, 191, 100, 256,   0, 256])
    """
    low, high = box.hue
    high = min(high, hues - 1)
    return np.array([low, high + 1 + (hues if low > high else 0),
                     box.saturation[0], box.saturation[1] + 1, box.value[0], box.value[1] + 1])


def box_of(edges: np.ndarray, hues: int) -> Box:
    """Return the box with these edges; all hues are those from the first to the last one.

    >>> box_of(np.array([170, 191, 100, 256, 0, 256]), 180)
    Box(hue=(170, 10), saturation=(100, 255), value=(0, 255))
    """
    low, end, *levels = map(int, edges)
    hue = (0, hues - 1) if end - low >= hues else (low % hues, (end - 1) % hues)
    return Box(hue, (levels[0], levels[1] - 1), (levels[2], levels[3] - 1))


class Sparse(NamedTuple):
    """The bins of a histogram that are not empty: their flat indices in order, and counts."""

    indices: np.ndarray
    counts: np.ndarray


def sparse(counts: np.ndarray) -> Sparse:
    """Return the bins of a histogram that are not empty."""
    indices = np.flatnonzero(counts != 0)       # five times faster than of the counts
    return Sparse(indices.astype(np.uint32), counts.reshape(-1)[indices].astype(np.int64))


class SummedVolume:
    """Counts the pixels in any box by eight look-ups, whatever its size.

    It is the table of Crow, "Summed-area tables for texture mapping" (SIGGRAPH 1984), in three
    dimensions. Levels at which there are no pixels are not in it. The hues are in it twice, one
    after the other, so that a range through 0 is one box as well.

    shape: number of hues, saturations and values; total: of all counts; filled: for each of the
    three, at which levels there are pixels.
    """

    def __init__(self, histogram: Sparse, shape: Tuple[int, ...]):
        """Sum a histogram of this shape up."""
        self.shape = shape
        places = np.unravel_index(histogram.indices, shape)
        self.total = int(histogram.counts.sum())
        # for each edge, how many levels below it have pixels
        below = [np.zeros(size + 1, np.intp) for size in self.shape]
        for each, levels in zip(below, places):
            each[levels + 1] = 1
            np.cumsum(each, out=each)
        self.filled = [np.diff(each) > 0 for each in below]
        hues, saturations, values = (int(each[-1]) for each in below)
        # half the memory; differences are right even if sums overflow, being below the total
        kind = np.uint32 if self.total <= np.iinfo(np.uint32).max else np.uint64
        table = np.zeros((2 * hues + 1, saturations + 1, values + 1), kind)
        once = table[1:hues + 1, 1:, 1:]
        once[tuple(each[levels] for each, levels in zip(below, places))] = histogram.counts
        np.cumsum(once, axis=2, out=once)
        for sums in (once, once.swapaxes(0, 1)):    # np.cumsum takes three times as long
            for before, each in zip(sums, sums[1:]):
                each += before
        np.add(once, table[hues, 1:, 1:], out=table[hues + 1:, 1:, 1:])
        self._table = table.reshape(-1)
        below[0] = np.concatenate([below[0], below[0][1:] + hues])
        self._offsets = [each * step for each, step in zip(
            below, ((saturations + 1) * (values + 1), values + 1, 1))]

    def count(self, edges: np.ndarray) -> np.ndarray:
        """Return the counts inside of boxes: int64 of shape (...).

        edges: int of shape (..., 6): the first hue, saturation and value, each with the one after
        the last; a hue range ends at most 2 * hues. A box that ends before it begins has nothing.
        """
        ranges = edges.reshape(-1, 3, 2).transpose(1, 2, 0)
        hue, saturation, value = (offsets.take(np.minimum(levels, levels[1]))
                                  for levels, offsets in zip(ranges, self._offsets))
        columns = []
        for first in hue:
            for second in saturation:
                sums = self._table.take(first + second + value)
                columns.append(sums[1] - sums[0])
        inside = columns[3] - columns[2] - columns[1] + columns[0]
        return inside.astype(np.int64).reshape(edges.shape[:-1])

    def count_along(self, axis: int, edges: np.ndarray, ranges: np.ndarray) -> np.ndarray:
        """Return the counts inside of boxes that differ in one axis: int64 of shape (n,).

        edges: of one of them, of shape (6,); ranges: their sides on the axis, of shape (2, n).
        """
        places = [offsets.take(np.minimum(sides, sides[1]))
                  for offsets, sides in zip(self._offsets, edges.reshape(3, 2))]
        first, second = (each for number, each in enumerate(places) if number != axis)
        # up to each level of the axis
        sums = self._table.take(np.add.outer(np.add.outer(first, second), self._offsets[axis]))
        sums = sums[1, 1] - sums[1, 0] - sums[0, 1] + sums[0, 0]
        low, end = sums.take(np.minimum(ranges, ranges[1]))
        return (end - low).astype(np.int64)
