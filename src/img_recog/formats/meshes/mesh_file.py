"""Reads mesh files (DAE, OBJ, STL) by trimesh, which is only loaded when there is one to read.

The image of a simulated camera and the physics use the same reader. PyBullet's own ones follow
the indices in a damaged file without a check, and ignore triangles that stand behind a comment.
"""
import io
import logging
import os
import re
from typing import Any, List, NamedTuple, Sequence, Set, Tuple

import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.files import plain
from img_recog.formats.meshes import collada, wavefront
from img_recog.formats.meshes.file_material import find_texture, number_of
from img_recog.formats.meshes.simplified import FilePart, Simplified
from img_recog.model import WHITE, WHOLE, Material, Submesh

_HEADER, _COUNT, _FACET = 80, 4, 50         # bytes; the facets follow their count
_CORNER = re.compile(rb'^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)', re.M | re.I)
_IS_ASCII = re.compile(rb'\A\s*(?:[#!$].*\s+)*(?:solid|facet|color)\b', re.I)
_FACETS = re.compile(rb'^[ \t]*facet\b', re.M | re.I)
_BINARY_FACET = np.dtype([('normal', '<f4', 3), ('corners', '<f4', (3, 3)), ('color', '<u2')])
READABLE = ('.dae', '.obj', '.stl')
# a triangle takes 300 bytes while it is read, and 108 when it is drawn
_MAX_BYTES, MAX_TRIANGLES = 1 << 28, 3_000_000
_MAX_POSITION = 1e9
_MIN_NORMAL = 0.5       # the length of one that a file gives, instead of 1


def simplified(content: bytes) -> bytes:
    """Return a binary STL with the facets of another one, binary or of text.

    Like in Gazebo, a text is not read as a whole: names and several solids do not matter, and it
    may end early. Raises ValueError for a facet that has not three corners.
    """
    start = _HEADER + _COUNT
    end = start + _FACET * int.from_bytes(content[_HEADER:start], 'little')
    lines = b''
    if len(content) != end and _IS_ASCII.match(content):
        lines = content.replace(b'\r', b'\n')
    count, corners = len(_FACETS.findall(lines)), _CORNER.findall(lines)
    if not count:       # what follows the facets does not matter
        return content[:end] if start < end <= len(content) else content
    if len(corners) != 3 * count:
        raise ValueError('it has {} corners in {} facets'.format(len(corners), count))
    facets = np.zeros(count, _BINARY_FACET)
    facets['corners'] = np.array(corners).astype(float).reshape(-1, 3, 3)
    return bytes(_HEADER) + count.to_bytes(_COUNT, 'little') + facets.tobytes()


class Triangles(NamedTuple):
    """Triangles of one material.

    positions (n, 3, 3): in m, a row a corner; normals (n, 3, 3): unit vectors; uvs (n, 3, 2): from
    the lower left corner of the texture; material: WHITE if the file states none, has_material:
    whether it does; problem: what of the file cannot be read, else ''; name: of the part of the
    file.
    """

    positions: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    material: Material = WHITE
    has_material: bool = False
    problem: str = ''
    name: str = ''


class MeshError(UserError):
    """A mesh file cannot be read."""


_Part = Tuple[Any, FilePart]      # of a trimesh.Trimesh


def read(path: str) -> List[Triangles]:
    """Return the triangles of a mesh file, in m, in the axes that the file uses.

    Like in Gazebo, the unit that a COLLADA file states counts, and its <up_axis> does not.
    Raises MeshError naming the file.
    """
    parts, problem = _parts(path)
    triangles = [_triangles(mesh, part) for mesh, part in parts]
    if problem:
        triangles[0] = triangles[0]._replace(
            problem='cannot read all of the mesh {}: {}'.format(path, problem))
    return triangles


def select(parts: List[Triangles], submesh: Submesh) -> List[Triangles]:
    """Return the part of a mesh that an SDF names; parts: of the whole; MeshError without it."""
    found = [part for part in parts if submesh.name in ('', part.name)]
    if not found:
        raise _missing(submesh, {part.name for part in parts})
    middle = _middle([part.positions for part in found], submesh)
    return [part._replace(positions=part.positions - middle) for part in found]


def _missing(submesh: Submesh, names: Set[str]) -> MeshError:
    return MeshError('the mesh has no submesh {}'.format(submesh.name),
                     'its submeshes are: ' + (', '.join(sorted(names - {''})) or 'none'))


def _middle(positions: Sequence[np.ndarray], submesh: Submesh) -> np.ndarray:
    """Return what comes to the origin (3,): of arrays (..., 3), the middle if it is centered."""
    if not submesh.is_centered:
        return np.zeros(3)
    bounds = [bound for each in positions for bound in (each.reshape(-1, 3).min(axis=0),
                                                        each.reshape(-1, 3).max(axis=0))]
    return (np.min(bounds, axis=0) + np.max(bounds, axis=0)) / 2


def write(path: str, folder: str, materials: bool = False, submesh: Submesh = WHOLE) -> str:
    """Write the shapes of a mesh file, in m, as a file that PyBullet can read; return its path.

    That is an OBJ for an OBJ, whose objects get a convex hull each, and else a binary STL.
    materials: whether to write those of an OBJ beside it; submesh: what is written of it.
    Raises MeshError naming the file that cannot be read.
    """
    import trimesh
    parts, _ = _parts(path)
    found = [(mesh, part) for mesh, part in parts if submesh.name in ('', part.name)]
    if not found:
        raise _missing(submesh, {part.name for _, part in parts})
    middle = _middle([mesh.vertices for mesh, _ in found], submesh)
    meshes = []
    for number, (mesh, part) in enumerate(found):
        written = trimesh.Trimesh(mesh.vertices - middle, mesh.faces, process=False)
        if materials and part.material is not None:
            # PyBullet has room for names of 4096 characters
            written.visual = trimesh.visual.TextureVisuals(
                uv=mesh.visual.uv, material=_simple_material(part.material, number))
        meshes.append(written)
    name = os.path.join(folder, 'mesh' + written_suffix(path))
    trimesh.Scene(meshes).export(name)
    return name


def _simple_material(material: Material, number: int) -> Any:
    from PIL import Image
    from trimesh.visual.material import SimpleMaterial

    from img_recog.formats import materials
    try:
        image = (Image.fromarray(materials.read_texture(material.texture)) if material.texture
                 else None)
    except materials.TextureError:
        image = None        # the image of a camera names it
    return SimpleMaterial(image=image, name='material_{}'.format(number),
                          diffuse=[round(255 * value) for value in material.color])


def written_suffix(path: str) -> str:
    """Return how the name of the file ends that `write` writes for a mesh file.

    >>> written_suffix('house.DAE'), written_suffix('chair.obj')
    ('.stl', '.obj')
    """
    return '.obj' if _suffix(path) == '.obj' else '.stl'


def read_content(path: str) -> bytes:
    """Return the content of a mesh file; MeshError when it is too large or cannot be read."""
    try:
        size = os.path.getsize(path)
        if size > _MAX_BYTES:
            raise ValueError('it has {} bytes, more than {}'.format(size, _MAX_BYTES))
        with open(path, 'rb', opener=plain) as file:
            return file.read()
    except (OSError, UserError, ValueError) as error:
        raise _unreadable(path, error)


def material_files(path: str) -> List[str]:
    """Return the paths of the files of materials that an OBJ names; MeshError like `read`."""
    return wavefront.libraries(read_content(path), path) if _suffix(path) == '.obj' else []


def _parts(path: str) -> Tuple[List[_Part], str]:
    """Return the parts of a mesh file in m with their materials, and what is left out, or ''."""
    content, suffix = read_content(path), _suffix(path)
    try:
        if suffix not in READABLE:
            raise ValueError('its name ends with {!r}, expected {}'.format(
                suffix, ', '.join(READABLE)))
        with np.errstate(invalid='ignore', over='ignore'):
            return _loaded(_simplified(content, suffix, path), suffix)
    except Exception as error:      # the readers raise errors of many types
        raise _unreadable(path, error)


def _unreadable(path: str, error: Exception) -> MeshError:
    return MeshError('cannot read the mesh {}: {}'.format(path, one_line(error)),
                     'give a DAE, OBJ or STL file that is complete')


def _suffix(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def _simplified(content: bytes, suffix: str, path: str) -> Simplified:
    if suffix == '.dae':
        return collada.simplified(content, lambda name: find_texture(path, name), MAX_TRIANGLES)
    if suffix == '.obj':
        return wavefront.simplified(content, path)
    return Simplified(simplified(content), [FilePart()])


def _loaded(file: Simplified, suffix: str) -> Tuple[List[_Part], str]:
    import trimesh
    logging.getLogger('trimesh').setLevel(logging.CRITICAL)     # what is left out is counted
    scene = trimesh.load_scene(io.BytesIO(file.content), file_type=suffix[1:], process=False,
                               resolver=_Library(file.mtl))
    # of simplified files each is there once, and where it is; dump() would drop the normals
    parts = [(mesh, file.parts[_number(mesh)]) for mesh in scene.geometry.values()
             if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
    parts = [(mesh if part.poses is None else _placed(mesh, part.poses), part)
             for mesh, part in parts]
    count = _count(parts)
    if not 0 < count <= MAX_TRIANGLES:
        raise ValueError('it has {} triangles, allowed are 1 to {}'.format(count, MAX_TRIANGLES))
    words = str(scene.units or '').split(' * ')     # as load_collada writes it
    unit = float(words[0]) if len(words) == 2 else 1.0
    if not unit > 0:
        raise ValueError('its unit has the length {:g}'.format(unit))
    # what is not a number is not less either
    usable = [(mesh, part) for mesh, part in parts
              if np.abs(mesh.vertices).max() * unit < _MAX_POSITION]
    if not usable:
        raise ValueError('it has a coordinate of more than {:g}'.format(_MAX_POSITION))
    for mesh, _ in usable if unit != 1 else ():
        mesh.apply_scale(unit)
    total = count if file.triangles is None else file.triangles
    return usable, '' if _count(usable) >= total else 'only {} of its {} triangles'.format(
        _count(usable), total)


def _count(parts: Sequence[_Part]) -> int:
    return sum(len(mesh.faces) for mesh, _ in parts)


def _placed(mesh: Any, poses: np.ndarray) -> Any:
    """Return a copy of a mesh at each pose (k, 4, 4), as one mesh."""
    import trimesh
    turns, count = poses[:, :3, :3], len(poses)
    vertices = mesh.vertices @ turns.transpose(0, 2, 1) + poses[:, None, :3, 3]
    faces = mesh.faces + len(mesh.vertices) * np.arange(count)[:, None, None]
    is_mirrored = np.linalg.det(turns) < 0
    faces[is_mirrored] = faces[is_mirrored, :, ::-1]
    normals = None
    if 'vertex_normals' in mesh._cache:         # not a getter, which would compute them
        normals = mesh.vertex_normals @ _of_normals(turns).transpose(0, 2, 1)
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
        normals = normals.reshape(-1, 3)
    uv = mesh.visual.uv
    visual = trimesh.visual.TextureVisuals(
        None if uv is None else np.tile(uv, (count, 1)), material=mesh.visual.material)
    return trimesh.Trimesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), visual=visual,
                           vertex_normals=normals, process=False)


def _of_normals(turns: np.ndarray) -> np.ndarray:
    """Return what turns normals where turns (k, 3, 3) with scales turn positions: their cofactors,
    as those of a scale of 0 have no inverse."""
    rows = turns[:, [1, 2, 0]], turns[:, [2, 0, 1]]
    signs = np.where(np.linalg.det(turns) < 0, -1, 1)
    return np.cross(*rows) * signs[:, None, None]


def _number(mesh: Any) -> int:
    """Return the number that the color of a mesh stands for, 0 for an STL, which has none."""
    return number_of(mesh.visual.material.main_color) if mesh.visual.kind == 'texture' else 0


def _triangles(mesh: Any, part: FilePart) -> Triangles:
    """Return what trimesh has read of one part."""
    positions = np.asarray(mesh.triangles, float)
    normals = np.repeat(mesh.face_normals[:, None], 3, axis=1)
    if 'vertex_normals' in mesh._cache:         # not a getter, which would compute them
        given = mesh.vertex_normals[mesh.faces]
        is_given = np.linalg.norm(given, axis=2, keepdims=True) > _MIN_NORMAL
        normals = np.where(is_given, given, normals)
    uvs = np.zeros((len(positions), 3, 2))
    if mesh.visual.kind == 'texture' and mesh.visual.uv is not None:
        uvs = np.asarray(mesh.visual.uv)[mesh.faces]
    return Triangles(positions, np.asarray(normals, float), uvs, part.material or WHITE,
                     part.material is not None, name=part.name)


class _Library:
    """Gives trimesh the file of materials of an OBJ, whatever its name is."""

    def __init__(self, text: str):
        self._text = text

    def get(self, name: str) -> bytes:
        """Return the file."""
        return self._text.encode()

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)
