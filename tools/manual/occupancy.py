"""An occupancy grid as a file, and its pillars."""
import os
from typing import Dict, NamedTuple, Sequence, Tuple

import numpy as np

Point = Tuple[float, float]

_SEARCH_M = 0.35        # around a pillar; the wall and other pillars are farther away
_MIN_CELLS, _PASSES = 3, 3
_OCCUPIED, _FREE = 65, 0
_WHITE, _GREY, _BLACK = 254, 205, 0     # of map_server


class Grid(NamedTuple):
    """cells: (height, width), 0 to 100 and -1 for unknown; origin: of cell 0, 0, m."""

    cells: np.ndarray
    resolution: float
    origin: Point


def save(grid: Grid, path: str) -> None:
    """Write PATH.pgm and PATH.yaml, as map_saver of map_server does."""
    pixels = np.full(grid.cells.shape, _GREY, np.uint8)
    pixels[grid.cells == _FREE] = _WHITE
    pixels[grid.cells >= _OCCUPIED] = _BLACK
    height, width = pixels.shape
    with open(path + '.pgm', 'wb') as file:
        file.write('P5\n{} {}\n255\n'.format(width, height).encode())
        file.write(pixels[::-1].tobytes())
    with open(path + '.yaml', 'w') as text:
        text.write('image: {}.pgm\nresolution: {:g}\norigin: [{:g}, {:g}, 0]\nnegate: 0\n'
                   'occupied_thresh: 0.65\nfree_thresh: 0.196\n'.format(
                       os.path.basename(path), grid.resolution, *grid.origin))


def find_pillars(grid: Grid, pillars: Sequence[Point], radius: float) -> Dict[Point, np.ndarray]:
    """Return the centers, m, of the pillars that are in the map, by their true centers.

    pillars: the true centers in the world, m. They are looked for there first, then where the
    frame of the map that follows has them: at its far end, a map that is turned is far off.
    """
    rows, columns = np.nonzero(grid.cells >= _OCCUPIED)
    points = (np.stack([columns, rows], 1) + 0.5) * grid.resolution + grid.origin
    places = np.array(pillars, float)
    for _ in range(_PASSES):
        near = {pillar: points[np.hypot(*(points - place).T) < _SEARCH_M]
                for pillar, place in zip(pillars, places)}
        found = {pillar: _center(cells, radius) for pillar, cells in near.items()
                 if len(cells) >= _MIN_CELLS}
        if len(found) > 1:
            places = MapFrame(found).from_world(pillars)
    return found


class MapFrame:
    """The frame of a map, which SLAM chooses, in that of the world.

    It is the rotation and the translation that fit the pillars best (Kabsch 1976).
    """

    def __init__(self, found: Dict[Point, np.ndarray]):
        """found: two pillars or more, as of `find_pillars`."""
        true, seen = np.array(list(found)), np.array(list(found.values()))
        self._true, self._seen = true.mean(axis=0), seen.mean(axis=0)
        u, _, v = np.linalg.svd((true - self._true).T @ (seen - self._seen))
        self._turn = u @ np.diag([1.0, np.linalg.det(u @ v)]) @ v

    def from_world(self, points: Sequence[Sequence[float]]) -> np.ndarray:
        """Return where points of the world, m, are in the map."""
        return (np.array(points) - self._true) @ self._turn + self._seen


def errors(found: Dict[Point, np.ndarray]) -> Tuple[float, float]:
    """Return the largest distances of a center from the true one, m: in world and map."""
    true, seen = list(found), np.array(list(found.values()))
    return (float(np.hypot(*(seen - true).T).max()),
            float(np.hypot(*(seen - MapFrame(found).from_world(true)).T).max()))


def _center(points: np.ndarray, radius: float, steps: int = 30) -> np.ndarray:
    """Return the center of the circle of this radius nearest to the points, by Gauss-Newton."""
    center = points.mean(axis=0)
    for _ in range(steps):
        away = points - center
        distance = np.maximum(np.hypot(*away.T), 1e-6)
        jacobian = -away / distance[:, None]
        center = center - np.linalg.lstsq(jacobian, distance - radius, rcond=None)[0]
    return center
