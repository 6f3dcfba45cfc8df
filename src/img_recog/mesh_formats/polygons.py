"""What the readers of the formats give to `mesh_file`, and how polygons become triangles."""
from typing import NamedTuple, Optional

import numpy as np

from img_recog.mesh_formats.file_material import FileMaterial


class FilePart(NamedTuple):
    """Triangles of a mesh file that have one name and one material.

    positions, normals (n, 3, 3), uvs (n, 3, 2): a row a corner; a normal is 0 where the file has
    none. material: None without one; name: the one that a <submesh> of an SDF can state.
    """

    positions: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    material: Optional[FileMaterial] = None
    name: str = ''


def fans(sizes: np.ndarray) -> np.ndarray:
    """Return the numbers (n, 3) of the corners of the triangles in polygons.

    sizes: of the polygons, whose corners are numbered one polygon after the other.

    >>> fans(np.array([3, 2, 4])).tolist()
    [[0, 1, 2], [5, 6, 7], [5, 7, 8]]
    """
    counts = np.maximum(sizes - 2, 0)
    first = np.repeat(np.cumsum(sizes) - sizes, counts)
    second = first + 1 + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([first, second, second + 1], axis=1)
