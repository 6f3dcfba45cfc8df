"""Meshes and textures as they are drawn: read once, and kept for the next start."""
import os
from typing import Any, List, Optional, Tuple

import numpy as np

from img_recog.formats import textures
from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.mesh_file import MeshError, Triangles
from img_recog.model import Material
from img_recog.rendering import disk_cache
from img_recog.rendering.file_cache import version

_TRIANGLES = np.dtype([('positions', 'f8', (3, 3)), ('normals', 'f8', (3, 3)),
                       ('uvs', 'f8', (3, 2))])


def read_mesh(path: str) -> List[Triangles]:
    """Return the triangles of a mesh file like `mesh_file.read`, whose errors it raises."""
    key = ('mesh', *map(version, [path, *mesh_file.material_files(path)]))
    kept = disk_cache.load(*key)
    parts = None if kept is None else _unpacked(*kept)
    if parts is None:
        parts = mesh_file.read(path)
        # where a texture is found may be another place the next time
        if _are_found(parts):
            disk_cache.store(*_packed(parts), *key)
    return parts


def files_of(path: str) -> List[str]:
    """Return the paths of a file and, if it is a mesh, of its materials and textures.

    One that is missing is among them too.
    """
    if not path.lower().endswith(mesh_file.READABLE) or not os.path.isfile(path):
        return [path]
    try:
        return [path, *mesh_file.material_files(path),
                *({part.material.texture for part in read_mesh(path)} - {''})]
    except MeshError:
        return [path]


def read_texture(path: str, mode: str = 'RGB') -> np.ndarray:
    """Return an image like `textures.read`, whose errors it raises."""
    key = 'texture', mode, *version(path)
    kept = disk_cache.load(*key)
    if kept is not None:
        return kept[0][::-1]
    image = textures.read(path, mode)
    disk_cache.store(image[::-1], None, *key)       # as OpenGL wants it: the lowest row first
    return image


def _are_found(parts: List[Triangles]) -> bool:
    textures_ = {part.material.texture for part in parts} - {''}
    return all(map(os.path.isfile, textures_))


def _packed(parts: List[Triangles]) -> Tuple[np.ndarray, Any]:
    array = np.empty(sum(len(part.positions) for part in parts), _TRIANGLES)
    for name in _TRIANGLES.names or ():
        array[name] = np.concatenate([getattr(part, name) for part in parts])
    return array, [[len(part.positions), *part[3:]] for part in parts]


def _with_tuple(value: Any) -> Any:
    """Return a value of JSON, which has lists in place of tuples."""
    return tuple(value) if isinstance(value, list) else value


def _unpacked(array: np.ndarray, about: Any) -> Optional[List[Triangles]]:
    """Return what was packed; None if a texture is not where it was."""
    ends = np.cumsum([count for count, *_ in about])
    parts = [Triangles(rows['positions'], rows['normals'], rows['uvs'],
                       Material(*map(_with_tuple, material)), *others)
             for rows, (_, material, *others) in zip(np.split(array, ends[:-1]), about)]
    return parts if _are_found(parts) else None
