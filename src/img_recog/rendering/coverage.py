"""Which part of an image boxes can cover: the rest need not be antialiased."""
from typing import Sequence, Tuple

import numpy as np

from img_recog.rendering import matrices

TILE_PX = 32
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
# the two corners of each edge of a box
_EDGES = np.array([(first, second) for first in range(8) for second in range(first)
                   if np.abs(_CORNERS[first] - _CORNERS[second]).sum() == 1]).T


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


def rectangles(corners: np.ndarray, to_clip: np.ndarray, near: float) -> np.ndarray:
    """Return the rectangles (n, 4) around boxes in an image: lowest x, y and highest x, y.

    corners (n, 8, 3): in the world; to_clip (4, 4): the view and projection, for which the image
    is from -1 to 1; near: the distance in m from which on something is seen. A box that is not
    seen has a lowest x of +inf.
    """
    clip = corners @ to_clip[:, :3].T + to_clip[:, 3]
    first, second = clip[:, _EDGES[0]], clip[:, _EDGES[1]]
    before, after = first[..., 3:], second[..., 3:]
    crosses = (before < near) != (after < near)
    share = np.where(crosses, (near - before) / np.where(crosses, after - before, 1), 0)
    points = np.concatenate([clip, first + share * (second - first)], axis=1)
    seen = np.concatenate([clip[..., 3:] >= near, crosses], axis=1)
    places = points[..., :2] / np.where(seen, np.maximum(points[..., 3:], near), 1)
    return np.concatenate([np.where(seen, places, np.inf).min(axis=1, initial=np.inf),
                           np.where(seen, places, -np.inf).max(axis=1, initial=-np.inf)], axis=1)


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
    marked = np.zeros((counts[1], counts[0] + 2), np.int8)
    for left, top, right, bottom in _tiles(rectangles_, size):
        marked[top:bottom, left + 1:right + 1] = 1
    steps = np.diff(marked, axis=1)
    rows, lefts = np.nonzero(steps == 1)
    _, rights = np.nonzero(steps == -1)
    tiles = np.stack([lefts, rows, rights, rows + 1], axis=1) * TILE_PX
    return tiles / np.tile(size, 2) * 2 - 1


def around(rectangles_: np.ndarray, width: int, height: int) -> Tuple[int, int, int, int]:
    """Return x, y, width and height in pixels of a rectangle that holds all that `runs` returns.

    rectangles_ (n, 4), width, height: like there, but at least one rectangle.
    """
    tiles = _tiles(rectangles_, np.array([width, height]))
    x, y = (tiles[:, :2].min(axis=0) * TILE_PX).tolist()
    end_x, end_y = np.minimum(tiles[:, 2:].max(axis=0) * TILE_PX, (width, height)).tolist()
    return x, y, end_x - x, end_y - y


def _tiles(rectangles_: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the first column and row of tiles that rectangles cover, and those after the last."""
    # and a pixel around, for the rounding of OpenGL
    low = ((rectangles_[:, :2] + 1) / 2 * size - 1).clip(0, size) / TILE_PX
    high = ((rectangles_[:, 2:] + 1) / 2 * size + 1).clip(0, size) / TILE_PX
    return np.hstack([np.floor(low), np.ceil(high)]).astype(int)


def triangles(rectangles_: np.ndarray) -> bytes:
    """Return the corners of two triangles for each rectangle (k, 4), as 32-bit numbers x, y."""
    return rectangles_[:, [0, 1, 2, 1, 0, 3, 0, 3, 2, 1, 2, 3]].astype('f4').tobytes()


def count_tiles(width: int, height: int) -> int:
    """Return how many rectangles `runs` returns at most."""
    columns, rows = -(-width // TILE_PX), -(-height // TILE_PX)
    return rows * (columns + 1) // 2 + rows
