"""The files of meshes that PyBullet reads: written from what trimesh has read, once for each mesh.

They stay in the user's folder for caches, so that trimesh, which takes 0.3 s and 40 MB, is only
loaded for a mesh that is new. They can be deleted at any time.
"""
from typing import Tuple

import numpy as np

from img_recog.errors import SimulationError
from img_recog.formats.generated_meshes import kept
from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.mesh_file import MeshError
from img_recog.model import WHOLE, Submesh

_STL_HEADER_BYTES = 84
_TRIANGLE = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('attributes', '<u2')])
_FOLDER = 'meshes_2'       # another number when the files change


def cached(path: str, submesh: Submesh = WHOLE) -> str:
    """Return the path of a file for PyBullet with the shapes of a mesh file, or of a part of it.

    The content of the mesh file tells which one. Raises SimulationError when that cannot be read
    or the cache cannot be written.
    """
    try:
        content = mesh_file.read_content(path)
        if submesh != WHOLE:
            content += repr(submesh).encode()
        return kept(_FOLDER, content, mesh_file.written_suffix(path),
                    lambda folder: mesh_file.write(path, folder, submesh=submesh))
    except MeshError as error:
        raise SimulationError(error.problem, error.advice)


def bounds(path: str) -> Tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest coordinates (3,) in a file that `cached` has returned."""
    if path.endswith('.stl'):
        triangles = np.fromfile(path, _TRIANGLE, offset=_STL_HEADER_BYTES)
        corners = triangles['corners'].reshape(-1, 3).astype(float)
    else:
        with open(path) as file:
            corners = np.array([line.split()[1:4] for line in file if line.startswith('v ')],
                               float)
    return corners.min(axis=0), corners.max(axis=0)
