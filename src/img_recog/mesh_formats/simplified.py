"""What the modules of the formats give to `mesh_file`."""
from typing import List, NamedTuple, Optional

from img_recog.mesh_formats.file_material import FileMaterial


class Simplified(NamedTuple):
    """A mesh file that trimesh reads whole.

    content: of it; materials: by the number that their color stands for, the first is that of
    triangles without one; triangles: how many it has, None if that was not counted; mtl: for an
    OBJ, its file of materials.
    """

    content: bytes
    materials: List[Optional[FileMaterial]]
    triangles: Optional[int] = None
    mtl: str = ''
