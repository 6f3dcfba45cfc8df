"""Mesh files of what an SDF describes by numbers or an image: terrain, outlines and roads.

They are Wavefront OBJ files in the user's folder for caches, named by their content. They can be
deleted while no world is loaded.
"""
import hashlib
import math
import os
import tempfile
from typing import Callable, List, Sequence, Tuple

import numpy as np

from img_recog.errors import SimulationError, one_line
from img_recog.files import cache_folder

_FOLDER = 'generated_1'    # another number when the files change
_MAX_CORNERS = 1000     # of an outline

_Mesh = Tuple[np.ndarray, np.ndarray, np.ndarray]       # vertices, faces and uvs, as for `write`


def kept(kind: str, content: bytes, suffix: str, make: Callable[[str], str]) -> str:
    """Return the path of the file that is made of some content; it is made if it is not there.

    kind: the folder in the cache; suffix: of the name. make: makes a file in the folder that it
    gets, and returns its path; what it raises is not kept.
    Raises SimulationError when the cache cannot be written.
    """
    folder = cache_folder(kind)
    path = os.path.join(folder, hashlib.sha256(content).hexdigest() + suffix)
    try:
        if not os.path.isfile(path):
            os.makedirs(folder, exist_ok=True)
            # another process may write the same file
            with tempfile.TemporaryDirectory(dir=folder) as own:
                os.replace(make(own), path)
    except OSError as error:
        raise SimulationError('cannot write to {}: {}'.format(folder, one_line(error)),
                              'set XDG_CACHE_HOME to a folder where files can be written')
    return path


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


def extruded(outlines: Sequence[Sequence[Sequence[float]]], height: float) -> str:
    """Write polygons that are extruded along z, from 0 to `height` in m; return the path.

    outlines: of the corners x, y in m, in any direction; each may be closed by repeating the
    first. One in another one is a hole, one in that is not.
    Raises SimulationError when one is no polygon, or the cache cannot be written.
    """
    polygons = [_corners(outline) for outline in outlines]
    around = [[other for other in polygons if other is not each and _holds(other, each[0])]
              for each in polygons]
    parts, total = [], 0
    for each, outer in zip(polygons, around):
        is_hole = len(outer) % 2 == 1
        walls = _wall(each[::-1] if is_hole else each, height)
        holes = [hole[::-1] for hole, others in zip(polygons, around)
                 if len(others) == len(outer) + 1 and any(other is each for other in others)]
        for vertices, faces, uvs in [walls] if is_hole else [
                _caps(_bridged(each, holes), height), walls]:
            parts.append((vertices, faces + total, uvs))
            total += len(vertices)
    vertices, faces, uvs = (np.concatenate(arrays) for arrays in zip(*parts))
    return write(vertices, faces, uvs)


def _corners(outline: Sequence[Sequence[float]]) -> np.ndarray:
    """Return the corners (n, 2) of an outline, anticlockwise."""
    corners = np.array(outline, float).reshape(-1, 2)
    corners = corners[np.any(corners != np.roll(corners, 1, axis=0), axis=1)]
    if not 3 <= len(corners) <= _MAX_CORNERS:
        raise SimulationError('got an outline of {} different corners, expected 3 to {}'.format(
            len(corners), _MAX_CORNERS))
    return corners[::-1] if _area(corners) < 0 else corners


def _wall(corners: np.ndarray, height: float) -> _Mesh:
    """Return the sides of a prism, whose outside is to the right of its outline."""
    count = len(corners)
    here = np.arange(count)
    there = np.roll(here, -1)
    # corners of their own, so that the edges are sharp
    along = np.cumsum(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1))
    lower = np.column_stack([here, there, there + count])
    upper = np.column_stack([here, there + count, here + count])
    return (_at_heights(corners, height), np.concatenate([lower, upper]),
            _at_heights(along, height))


def _caps(corners: np.ndarray, height: float) -> _Mesh:
    """Return the faces below and above a prism with an anticlockwise outline."""
    count, cap = len(corners), np.array(_ears(corners))
    return (_at_heights(corners, height), np.concatenate([cap[:, ::-1], cap + count]),
            np.concatenate([corners, corners]))


def _at_heights(values: np.ndarray, height: float) -> np.ndarray:
    """Return values (n, ...) with a height of 0 beside each, and then with the other one."""
    zeros = np.zeros(len(values))
    lower = np.column_stack([values, zeros])
    upper = np.column_stack([values, zeros + height])
    return np.concatenate([lower, upper])


def _bridged(corners: np.ndarray, holes: Sequence[np.ndarray]) -> np.ndarray:
    """Return an outline around a polygon without holes in it, which are clockwise: each is joined
    to the outline by an edge there and back, the shortest that crosses no other."""
    rest = list(holes)
    while rest:
        edges = np.concatenate([np.stack([each, np.roll(each, -1, axis=0)], axis=1)
                                for each in (corners, *rest)])
        pairs = sorted((math.dist(corners[first], hole[second]), first, number, second)
                       for number, hole in enumerate(rest)
                       for first in range(len(corners)) for second in range(len(hole)))
        _, first, number, second = next(
            (pair for pair in pairs if not _crosses(
                corners[pair[1]], rest[pair[2]][pair[3]], edges)), pairs[0])
        hole = np.roll(rest.pop(number), -second, axis=0)
        corners = np.concatenate([corners[:first + 1], hole, hole[:1], corners[first:]])
    return corners


def _crosses(start: np.ndarray, end: np.ndarray, edges: np.ndarray) -> bool:
    """Return whether a line crosses one of some edges (n, 2, 2), other than at its ends."""
    def side(line: np.ndarray, start: np.ndarray, point: np.ndarray) -> np.ndarray:
        to_point = point - start
        return np.sign(line[..., 0] * to_point[..., 1] - line[..., 1] * to_point[..., 0])

    along = edges[:, 1] - edges[:, 0]
    return bool(np.any(
        (side(end - start, start, edges[:, 0]) * side(end - start, start, edges[:, 1]) < 0)
        & (side(along, edges[:, 0], start) * side(along, edges[:, 0], end) < 0)))


def _holds(corners: np.ndarray, point: np.ndarray) -> bool:
    """Return whether a point (2,) is in a polygon."""
    x, y = corners.T - point[:, None]
    next_x, next_y = np.roll(x, -1), np.roll(y, -1)
    beside = (y > 0) != (next_y > 0)
    return bool(np.count_nonzero(
        x[beside] - y[beside] * (next_x - x)[beside] / (next_y - y)[beside] > 0) % 2)


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
            # corners at which a hole is joined are there twice
            others = [each for each in left if not any(
                np.array_equal(corners[each], corners[corner]) for corner in ear)]
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
