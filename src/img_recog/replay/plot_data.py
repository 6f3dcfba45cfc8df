"""The data from which the picture of a drive is drawn."""
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from img_recog.recognition.recognition_settings import Color

TIME, X, Y, YAW, SPEED, TURN = range(6)         # columns of `motion`
MAX_ROWS = 1 << 14      # of a line in the picture, which has 800 pixels for them


class PlotColor(NamedTuple):
    """A color of which only this is known. area_limit_px: None if not known."""

    name: str
    hue: Tuple[int, int]
    area_limit_px: Optional[int] = None


class PlotData(NamedTuple):
    """The data of a replay, or of a drive that was recorded.

    motion: shape (states, 6), at least one state of the robot; the columns are named above.
    areas: shape (images, 1 + colors), time in s and area of each color in pixels.
    commands, idle: shape (commands, 3), time in s, linear.x in m/s, angular.z in rad/s; idle: of
    senders that say nothing else than zero.
    end_s: time of the end. outlines: shape (corners, 2) in m, of the objects in the world.
    moved: numbers of the states to which the robot was put, rather than driven.
    """

    colors: Sequence[Union[Color, PlotColor]]
    motion: np.ndarray
    areas: np.ndarray
    commands: np.ndarray
    idle: np.ndarray
    end_s: float
    outlines: Sequence[np.ndarray]
    moved: Sequence[int] = ()


class Rows:
    """Rows of numbers in the order of time, of which at most MAX_ROWS are kept.

    If there are more, two rows replace each block of rows. In the first columns, these are the
    first and the last row of the block; in the others, its lowest and its highest values.
    """

    def __init__(self, columns: int, first_columns: int):
        self._rows, self._first_columns = np.empty((MAX_ROWS, columns)), first_columns
        self._count, self._block_size = 0, 1
        self._block: List[Sequence[float]] = []

    def add(self, row: Sequence[float]) -> None:
        """Add a row."""
        self._block.append(row)
        if len(self._block) < self._block_size:
            return
        rows: Any = self._pairs(self._block) if self._block_size > 1 else self._block
        self._rows[self._count:self._count + len(rows)] = rows
        self._count, self._block = self._count + len(rows), []
        if self._count == MAX_ROWS:
            self._rows[:MAX_ROWS // 2] = self._pairs(self._rows.reshape(-1, 4, len(row)))
            self._count, self._block_size = MAX_ROWS // 2, max(4, 2 * self._block_size)

    def _pairs(self, blocks: Any) -> np.ndarray:
        """Return two rows for a block of rows, or for each of several blocks."""
        blocks = np.reshape(blocks, (-1, *np.shape(blocks)[-2:]))
        found = np.stack([blocks.min(axis=1), blocks.max(axis=1)], axis=1)
        found[..., :self._first_columns] = blocks[:, [0, -1], :self._first_columns]
        return found.reshape(-1, found.shape[2])

    def array(self) -> np.ndarray:
        """Return all rows that are kept; the newest row is the last."""
        return np.concatenate([self._rows[:self._count],
                               np.reshape(self._block, (-1, self._rows.shape[1]))])
