"""What the modules of the formats give to `mesh_file`."""
from typing import NamedTuple, Optional, Sequence

import numpy as np

from img_recog.model import Material


class FilePart(NamedTuple):
    """What a mesh file says of some of its triangles.

    name: the one that a <submesh> of an SDF can state; material: None without one; poses
    (k, 4, 4): where they are, in the unit of the file; None for where they are in it.
    """

    name: str = ''
    material: Optional[Material] = None
    poses: Optional[np.ndarray] = None


class Simplified(NamedTuple):
    """A mesh file that trimesh reads whole.

    content: of it; parts: by the number that the color of their triangles stands for; triangles:
    how many it has, None if that was not counted; mtl: for an OBJ, its file of materials.
    """

    content: bytes
    parts: Sequence[FilePart]
    triangles: Optional[int] = None
    mtl: str = ''
