"""Mesh files of what an SDF describes by numbers or an image: terrain, outlines and roads.

They are Wavefront OBJ files in the user's folder for caches, named by their content. They can be
deleted while no world is loaded.
"""
import os
from typing import List, Sequence, Tuple

import numpy as np

from img_recog.errors import SimulationError
from img_recog.formats.kept_files import kept

_FOLDER = 'generated_1'    # another number when the files change
_MAX_CORNERS = 1000     # of an outline


def write(vertices: np.ndarray, faces: np.ndarray, uvs: np.ndarray) -> str:
    """Write triangles; return the path of the file.

    vertices (n, 3): m; faces (m, 3): numbers of vertices, anticlockwise; uvs (n, 2): texture
    coordinates of the vertices.
    Raises SimulationError when the cache cannot be written.
    """
    lines = ['v {:.7g} {:.7g} {:.7g}'.format(*row) for row in vertices.tolist()]
    lines += ['vt {:.7g} {:.7g}'.format(*row) for row in uvs.tolist()]
    lines += ['f {0}/{0} {1}/{1} {2}/{2}'.format(*row) for row in (faces + 1).tolist()]
    content = ('\n'.join(lines) + '\n').encode()

    def make(folder: str) -> str:
        path = os.path.join(folder, 'mesh')
        with open(path, 'wb') as file:
            file.write(content)
        return path
    return kept(_FOLDER, content, '.obj', make)


def grid_faces(rows: int, columns: int) -> np.ndarray:
    """Return the faces (n, 3) of a grid whose vertices are numbered row by row.

    Seen so that the columns go to the right and the rows upward, they are anticlockwise.

    >>> grid_faces(2, 2).tolist()
    [[0, 1, 3], [0, 3, 2]]
    """
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    corners = [first, first + 1, first + columns + 1, first + columns]
    return np.stack([corners[0], corners[1], corners[2], corners[0], corners[2], corners[3]],
                    axis=1).reshape(-1, 3)


def extruded(outline: Sequence[Sequence[float]], height: float) -> str:
    """Write a polygon that is extruded along z, from 0 to `height` in m; return the path.

    outline: of the corners x, y in m, in any direction; it may be closed by repeating the first.
    Raises SimulationError when it is no polygon, or the cache cannot be written.
    """
    corners = np.array(outline, float).reshape(-1, 2)
    corners = corners[np.any(corners != np.roll(corners, 1, axis=0), axis=1)]
    if not 3 <= len(corners) <= _MAX_CORNERS:
        raise SimulationError('got an outline of {} different corners, expected 3 to {}'.format(
            len(corners), _MAX_CORNERS))
    if _area(corners) < 0:
        corners = corners[::-1]
    count, cap = len(corners), np.array(_ears(corners))
    vertices = np.concatenate([np.column_stack([corners, np.full(count, z)])
                               for z in (0.0, height)])
    here = np.arange(count)
    there = np.roll(here, -1)
    walls = np.concatenate([np.column_stack([here, there, there + count]),
                            np.column_stack([here, there + count, here + count])])
    # corners of their own for the walls, so that the edges are sharp
    along = np.cumsum(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1))
    uvs = np.concatenate([corners, corners, *(np.column_stack([along, np.full(count, z)])
                                              for z in (0.0, height))])
    return write(np.concatenate([vertices, vertices]),
                 np.concatenate([cap[:, ::-1], cap + count, walls + 2 * count]), uvs)


def _area(corners: np.ndarray) -> float:
    """Return the area within corners (n, 2), negative if they are clockwise."""
    x, y = corners.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _ears(corners: np.ndarray) -> List[Tuple[int, int, int]]:
    """Return the triangles of an anticlockwise polygon, by clipping ears."""
    left, triangles = list(range(len(corners))), []
    while len(left) > 3:
        for number in range(len(left)):
            ear = left[number - 1], left[number], left[(number + 1) % len(left)]
            others = [each for each in left if each not in ear]
            if _area(corners[list(ear)]) > 0 and not _inside(corners[others], corners[list(ear)]):
                break
        else:       # the outline crosses itself: whatever is left has no ear
            number, ear = 1, (left[0], left[1], left[2])
        triangles.append(ear)
        left.pop(number)
    return [*triangles, (left[0], left[1], left[2])]


def _inside(points: np.ndarray, triangle: np.ndarray) -> bool:
    """Return whether one of some points (n, 2) is in an anticlockwise triangle."""
    edges = np.roll(triangle, -1, axis=0) - triangle
    offsets = points[:, None] - triangle
    return bool(np.any(np.all(
        edges[:, 0] * offsets[:, :, 1] - edges[:, 1] * offsets[:, :, 0] >= 0, axis=1)))
