"""Which part of an image boxes can cover: the rest need not be antialiased."""
from typing import Sequence, Tuple

import numpy as np

from img_recog.rendering import matrices

TILE_PX = 32
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
# the two corners of each edge of a box
_EDGES = np.array([(first, second) for first in range(8) for second in range(first)
                   if np.abs(_CORNERS[first] - _CORNERS[second]).sum() == 1]).T
TRIANGLES = [0, 1, 2, 2, 1, 3]      # which of the `corners` of a rectangle are those of two
WHOLE = np.array([[-1, -1, 1, 1]])  # the rectangle of an image


class Boxes:
    """Boxes that move with parts, and cover all that is drawn.

    parts (n,): the number of the part of each, -1 for the world.
    """

    def __init__(self, bounds: Sequence[Tuple[int, np.ndarray, np.ndarray]]):
        """Make them.

        bounds: for each box the number of its part, -1 for the world, and its lowest and highest
        x, y and z in the frame of the part.
        """
        self.parts = np.array([part for part, _, _ in bounds], int)
        low = np.array([low for _, low, _ in bounds]).reshape(-1, 1, 3)
        high = np.array([high for _, _, high in bounds]).reshape(-1, 1, 3)
        self._corners = low + _CORNERS * (high - low)

    def in_world(self, models: np.ndarray) -> np.ndarray:
        """Return the corners (n, 8, 3); models (m, 4, 4): transforms of the parts."""
        moved = matrices.of_parts(models, self.parts)
        return self._corners @ moved[:, :3, :3].transpose(0, 2, 1) + moved[:, np.newaxis, :3, 3]


def rectangles(boxes: np.ndarray, to_clip: np.ndarray, near: float) -> np.ndarray:
    """Return the rectangles (n, 4) around boxes in an image: lowest x, y and highest x, y.

    boxes (n, 8, 3): their corners in the world; to_clip (4, 4): the view and projection, for
    which the image is from -1 to 1; near: the distance in m from which on something is seen. A
    box that is not seen has a lowest x of +inf.
    """
    clip = boxes @ to_clip[:, :3].T + to_clip[:, 3]
    is_ahead = clip[..., 3] >= near
    found = _around(clip, is_ahead)
    is_cut = is_ahead.any(axis=1) & ~is_ahead.all(axis=1)
    if is_cut.any():        # where edges cross the plane at `near` counts, too
        first, second = clip[is_cut][:, _EDGES[0]], clip[is_cut][:, _EDGES[1]]
        before, after = first[..., 3:], second[..., 3:]
        crosses = (before < near) != (after < near)
        share = np.where(crosses, (near - before) / np.where(crosses, after - before, 1), 0)
        cut = _around(first + share * (second - first), crosses[..., 0])
        found[is_cut, :2] = np.minimum(found[is_cut, :2], cut[:, :2])
        found[is_cut, 2:] = np.maximum(found[is_cut, 2:], cut[:, 2:])
    return found


def _around(clip: np.ndarray, is_counted: np.ndarray) -> np.ndarray:
    """Return the rectangles (n, 4) around points (n, k, 4) that count (n, k)."""
    counts = is_counted[..., np.newaxis]
    places = clip[..., :2] / np.where(counts, clip[..., 3:], 1)
    return np.concatenate([np.where(counts, places, np.inf).min(axis=1, initial=np.inf),
                           np.where(counts, places, -np.inf).max(axis=1, initial=-np.inf)], axis=1)


def are_on_image(rectangles_: np.ndarray) -> np.ndarray:
    """Return (n,) which rectangles (n, 4), as returned by `rectangles`, overlap the image.

    >>> are_on_image(np.array([[0.5, 0, 2, 0.2], [1.5, 0, 2, 0.2]])).tolist()
    [True, False]
    """
    return (rectangles_[:, :2] <= 1).all(axis=1) & (rectangles_[:, 2:] >= -1).all(axis=1)


def runs(rectangles_: np.ndarray, width: int, height: int) -> np.ndarray:
    """Return rectangles (k, 4) of whole tiles, of which no two overlap, that hold others.

    rectangles_ (n, 4): of what is on the image, as returned by `rectangles`, and so is the result.
    width, height: of the image in pixels.
    """
    size = np.array([width, height])
    counts = -(-size // TILE_PX)
    marked = np.zeros(counts[::-1], bool)
    for left, top, right, bottom in _tiles(rectangles_, size):
        marked[top:bottom, left:right] = True
    rows, edges = np.nonzero(np.diff(marked, axis=1, prepend=False, append=False))
    rows, lefts, rights = rows[::2], edges[::2], edges[1::2]
    tiles = np.stack([lefts, rows, rights, rows + 1], axis=1) * TILE_PX
    return tiles / np.tile(size, 2) * 2 - 1


def _tiles(rectangles_: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the first column and row of tiles that rectangles cover, and those after the last."""
    # and a pixel around, for the rounding of OpenGL
    low = ((rectangles_[:, :2] + 1) / 2 * size - 1).clip(0, size) / TILE_PX
    high = ((rectangles_[:, 2:] + 1) / 2 * size + 1).clip(0, size) / TILE_PX
    return np.hstack([np.floor(low), np.ceil(high)]).astype(int)


def corners(rectangles_: np.ndarray) -> np.ndarray:
    """Return the corners (k, 4, 2) of rectangles (k, 4), row by row."""
    return rectangles_[:, [0, 1, 2, 1, 0, 3, 2, 3]].reshape(-1, 4, 2)


def triangles(rectangles_: np.ndarray) -> bytes:
    """Return the corners of two triangles for each rectangle (k, 4), as 32-bit numbers x, y."""
    return corners(rectangles_)[:, TRIANGLES].astype('f4').tobytes()


def count_tiles(width: int, height: int) -> int:
    """Return how many rectangles `runs` returns at most."""
    columns, rows = -(-width // TILE_PX), -(-height // TILE_PX)
    return rows * -(-columns // 2)
