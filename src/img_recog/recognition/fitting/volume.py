"""The summed volume table of a histogram over hue, saturation and value."""
from typing import NamedTuple, Tuple

import numpy as np

_CORNERS = [(1, 1, 1), (0, 1, 1), (1, 0, 1), (1, 1, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0),
            (0, 0, 0)]
_MAX_UINT32 = 1 << 32


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


class SummedVolume:
    """Counts the pixels in any box by eight look-ups, whatever its size.

    It is the table of Crow, "Summed-area tables for texture mapping" (SIGGRAPH 1984), in three
    dimensions. The hues are in it twice, one after the other, so that a range through 0 is one
    box as well.

    shape: number of hues, saturations and values; total: of all counts.
    """

    def __init__(self, counts: np.ndarray):
        """Sum a histogram up; counts: whole numbers of shape (hues, saturations, values)."""
        self.shape = counts.shape
        self.total = int(counts.sum())
        hues, saturations, values = counts.shape
        # half the memory; differences are right even if sums overflow, being below the total
        kind = np.uint32 if self.total < _MAX_UINT32 else np.uint64
        table = np.zeros((2 * hues + 1, saturations + 1, values + 1), kind)
        once = table[1:hues + 1, 1:, 1:]
        once[:] = counts
        for axis in range(3):
            np.cumsum(once, axis=axis, out=once)
        np.add(once, once[-1], out=table[hues + 1:, 1:, 1:])
        self._table = table.reshape(-1)
        self._strides = np.array([(saturations + 1) * (values + 1), values + 1, 1])

    def count(self, edges: np.ndarray) -> np.ndarray:
        """Return the counts inside of boxes: int64 of shape (...).

        edges: int of shape (..., 6): the first hue, saturation and value, each with the one after
        the last; a hue range ends at most 2 * hues. A box that ends before it begins has nothing.
        """
        ends = edges.reshape(-1, 6)[:, 1::2]
        lows = np.minimum(edges.reshape(-1, 6)[:, ::2], ends)
        result = np.zeros(len(ends), self._table.dtype)
        corners = lows * self._strides, ends * self._strides
        for corner in _CORNERS:
            index = sum(corners[end][:, axis] for axis, end in enumerate(corner))
            looked_up = self._table[index]
            result = result + looked_up if sum(corner) % 2 else result - looked_up
        return result.astype(np.int64).reshape(edges.shape[:-1])
