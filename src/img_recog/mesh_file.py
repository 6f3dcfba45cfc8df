"""Reads mesh files (DAE, OBJ, STL), and writes them for PyBullet.

The image of a simulated camera and the physics use the same reader. PyBullet's own ones follow
the indices in a damaged file without a check, and ignore triangles that stand behind a comment.
"""
import os
from typing import List, NamedTuple, Tuple

import cv2
import numpy as np

from img_recog import textures
from img_recog.errors import UserError, one_line
from img_recog.mesh_formats import collada, stl, wavefront
from img_recog.mesh_formats.file_material import FileMaterial, find_texture
from img_recog.mesh_formats.polygons import FilePart
from img_recog.visuals import GREY, WHOLE, Color, Submesh

READABLE = ('.dae', '.obj', '.stl')
# a triangle takes 300 bytes while it is read, and 108 when it is drawn
_MAX_BYTES, MAX_TRIANGLES = 1 << 28, 3_000_000
_MAX_POSITION = 1e9
_LIBRARY = 'mesh.mtl'    # the file of materials of a written OBJ


class Triangles(NamedTuple):
    """Triangles of one material.

    positions (n, 3, 3): in m, a row a corner; normals (n, 3, 3): unit vectors; uvs (n, 3, 2): from
    the lower left corner of the texture; color: of the material; texture: the path of an image
    file, '' for none, that replaces the color but for its opacity; has_material: whether the file
    states the color or texture; problem: what of the file cannot be read, else ''; name: of the
    part of the file.
    """

    positions: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    color: Color = GREY
    texture: str = ''
    has_material: bool = False
    problem: str = ''
    name: str = ''


class MeshError(UserError):
    """A mesh file cannot be read."""


def read(path: str) -> List[Triangles]:
    """Return the triangles of a mesh file, in m, in the axes that the file uses.

    Like in Gazebo, the unit that a COLLADA file states counts, and its <up_axis> does not.
    Raises MeshError naming the file.
    """
    content, suffix = read_content(path), _suffix(path)
    try:
        if suffix not in READABLE:
            raise ValueError('its name ends with {!r}, expected {}'.format(
                suffix, ', '.join(READABLE)))
        with np.errstate(all='ignore'):
            parts, problem = _usable(*_parts(content, suffix, path))
            triangles = [_triangles(part) for part in parts]
    except Exception as error:      # the readers raise errors of many types
        raise _unreadable(path, error)
    if problem:
        triangles[0] = triangles[0]._replace(
            problem='cannot read all of the mesh {}: {}'.format(path, problem))
    return triangles


def _parts(content: bytes, suffix: str, path: str) -> Tuple[List[FilePart], int]:
    """Return the parts of a mesh file in m, and how many triangles they should have."""
    if suffix == '.dae':
        return collada.read(content, lambda name: find_texture(path, name), MAX_TRIANGLES)
    if suffix == '.obj':
        parts = wavefront.read(content, path)
    else:
        positions = stl.read(content)
        parts = [FilePart(positions, np.zeros_like(positions), np.zeros_like(positions[..., :2]))]
    return parts, _count(parts)


def _count(parts: List[FilePart]) -> int:
    return sum(len(part.positions) for part in parts)


def _usable(parts: List[FilePart], total: int) -> Tuple[List[FilePart], str]:
    """Return the parts that can be used, and what is left out, or ''."""
    parts = [part for part in parts if len(part.positions)]
    if not 0 < _count(parts) <= MAX_TRIANGLES:
        raise ValueError('it has {} triangles, allowed are 1 to {}'.format(
            _count(parts), MAX_TRIANGLES))
    # what is not a number is not less either
    usable = [part for part in parts if np.abs(part.positions).max() < _MAX_POSITION]
    if not usable:
        raise ValueError('it has a coordinate of more than {:g}'.format(_MAX_POSITION))
    count = _count(usable)
    return usable, '' if count >= total else 'only {} of its {} triangles'.format(count, total)


def _triangles(part: FilePart) -> Triangles:
    sides = part.positions[:, 1:] - part.positions[:, :1]
    of_faces = _of_length_1(np.cross(sides[:, 0], sides[:, 1]))[:, None]
    given = _of_length_1(part.normals)
    is_given = np.isfinite(given).all(axis=2, keepdims=True) & given.any(axis=2, keepdims=True)
    color, texture = part.material or FileMaterial()
    return Triangles(part.positions, np.where(is_given, given, of_faces), part.uvs, color, texture,
                     part.material is not None, name=part.name)


def _of_length_1(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (..., 3) with the length 1; 0 stays 0."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths == 0, 1, lengths)


def select(parts: List[Triangles], submesh: Submesh) -> List[Triangles]:
    """Return the part of a mesh that an SDF names; parts: of the whole; MeshError without it."""
    found = [part for part in parts if submesh.name in ('', part.name)]
    if not found:
        names = {part.name for part in parts} - {''}
        raise MeshError('the mesh has no submesh {}'.format(submesh.name),
                        'its submeshes are: ' + (', '.join(sorted(names)) or 'none'))
    if not submesh.is_centered:
        return found
    corners = np.concatenate([part.positions.reshape(-1, 3) for part in found])
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    return [part._replace(positions=part.positions - middle) for part in found]


def write(path: str, folder: str, materials: bool = False, submesh: Submesh = WHOLE) -> str:
    """Write the shapes of a mesh file, in m, as a file that PyBullet can read; return its path.

    That is an OBJ for an OBJ, whose objects get a convex hull each, and else a binary STL.
    materials: whether to write those of an OBJ beside it; submesh: what is written of it.
    Raises MeshError naming the file that cannot be read.
    """
    parts = select(read(path), submesh)
    name = os.path.join(folder, 'mesh' + written_suffix(path))
    if not name.endswith('.obj'):
        with open(name, 'wb') as file:
            file.write(stl.written(np.concatenate([part.positions for part in parts])))
        return name
    if materials:
        with open(os.path.join(folder, _LIBRARY), 'w') as library:
            library.write(''.join(_material(part, number, folder)
                                  for number, part in enumerate(parts) if part.has_material))
    with open(name, 'w') as text:
        text.write(wavefront.written(
            [np.concatenate([part.positions, part.uvs], axis=2) for part in parts], _LIBRARY)
            if materials else wavefront.written([part.positions for part in parts]))
    return name


def _material(part: Triangles, number: int, folder: str) -> str:
    """Return the lines of a file of materials for a part; write its texture beside that."""
    lines = 'newmtl {}\nKd {} {} {}\n'.format(number, *part.color[:3])
    try:
        if part.texture:
            # PyBullet has room for names of 4096 characters
            name = 'texture_{}.png'.format(number)
            cv2.imwrite(os.path.join(folder, name), textures.read(part.texture)[..., ::-1])
            lines += 'map_Kd {}\n'.format(name)
    except textures.TextureError:
        pass                # the image of a camera names it
    return lines


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
        with open(path, 'rb') as file:
            return file.read()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error)


def material_files(path: str) -> List[str]:
    """Return the paths of the files of materials that an OBJ names; MeshError like `read`."""
    return wavefront.libraries(read_content(path), path) if _suffix(path) == '.obj' else []


def _unreadable(path: str, error: Exception) -> MeshError:
    return MeshError('cannot read the mesh {}: {}'.format(path, one_line(error)),
                     'give a DAE, OBJ or STL file that is complete')


def _suffix(path: str) -> str:
    return os.path.splitext(path)[1].lower()
