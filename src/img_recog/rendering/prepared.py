"""Meshes and textures as they are drawn: read once, and kept for the next start."""
import concurrent.futures
import contextlib
import hashlib
import json
import os
import uuid
from typing import Any, Callable, Dict, Generic, List, Optional, Tuple, TypeVar

import numpy as np

from img_recog.files import cache_folder
from img_recog.formats import materials
from img_recog.formats.meshes import mesh_file
from img_recog.formats.meshes.mesh_file import MeshError, Triangles
from img_recog.model import Material

Value = TypeVar('Value')
_FOLDER = 'drawn_4'        # another number when the files change
MAX_BYTES = 2 << 30        # of all files; then those that were not used for longest are removed

# writing takes as long as reading: not while the first image is waited for
_writer = concurrent.futures.ThreadPoolExecutor(1)

Entry = Tuple[np.ndarray, Any]      # an array that cannot be changed, and what JSON can hold
_TRIANGLES = np.dtype([('positions', 'f8', (3, 3)), ('normals', 'f8', (3, 3)),
                       ('uvs', 'f8', (3, 2))])


class FileCache(Generic[Value]):
    """Reads each file once, and again when it has changed."""

    def __init__(self, read: Callable[[str], Value]):
        """read: returns what is in the file at a path."""
        self._read = read
        self._kept: Dict[Tuple[str, int, int], Value] = {}
        self._used: Dict[Tuple[str, int, int], Value] = {}

    def get(self, path: str) -> Value:
        """Return what is in a file; what `read` raises is not kept."""
        key = version(path)
        if key not in self._used:
            self._used[key] = self._kept[key] if key in self._kept else self._read(path)
        return self._used[key]

    def forget_unused(self) -> None:
        """Keep only what `get` has returned since the last call of this."""
        self._kept, self._used = self._used, {}


def version(path: str) -> Tuple[str, int, int]:
    """Return what tells whether a file has changed."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return path, 0, 0
    return os.path.abspath(path), status.st_mtime_ns, status.st_size


def load_stored(*key: Any) -> Optional[Entry]:
    """Return what `store` has kept under a key; None if there is nothing, or it is damaged."""
    path = os.path.join(cache_folder(_FOLDER), _name(key))
    try:
        array = np.load(path, mmap_mode='r')
        with open(path, 'rb') as file:
            file.seek(array.offset + array.nbytes)
            about = json.loads(file.read().decode())
        os.utime(path)
    except (EOFError, OSError, ValueError):     # EOFError: numpy 2, of an empty file
        return None
    return np.asarray(array), about


def store_prepared(array: np.ndarray, about: Any, *key: Any) -> None:
    """Keep an array and what is to know of it, if the disk has room for them.

    That is done in a thread. The array must not be changed.
    """
    _writer.submit(_write, cache_folder(_FOLDER), _name(key), array, about)


def wait_for_writers() -> None:
    """Wait until all is written that was to be stored."""
    _writer.submit(int).result()


def _write(folder: str, name: str, array: np.ndarray, about: Any) -> None:
    # another process may write the same file; one that is killed leaves a part, which
    # `_make_room` removes some day
    part = os.path.join(folder, uuid.uuid4().hex)
    try:
        os.makedirs(folder, exist_ok=True)
        _make_room(folder, array.nbytes)
        with open(part, 'xb') as file:
            np.save(file, array, allow_pickle=False)
            file.write(json.dumps(about).encode())
        os.replace(part, os.path.join(folder, name))
    except OSError:
        with contextlib.suppress(OSError):
            os.remove(part)


def _name(key: Tuple[Any, ...]) -> str:
    return hashlib.sha256(repr(key).encode()).hexdigest() + '.npy'


def _make_room(folder: str, size: int) -> None:
    with os.scandir(folder) as entries:
        files = [(entry.stat(), entry.path) for entry in entries if entry.is_file()]
    total = size + sum(status.st_size for status, _ in files)
    for status, path in sorted(files, key=lambda each: each[0].st_mtime_ns):
        if total > MAX_BYTES:
            os.remove(path)
            total -= status.st_size


def read_mesh(path: str) -> List[Triangles]:
    """Return the triangles of a mesh file like `mesh_file.read`, whose errors it raises."""
    key = ('mesh', *map(version, [path, *mesh_file.material_files(path)]))
    kept = load_stored(*key)
    parts = None if kept is None else _unpacked(*kept)
    if parts is None:
        parts = mesh_file.read(path)
        # where a texture is found may be another place the next time
        if _are_found(parts):
            store_prepared(*_packed(parts), *key)
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
    kept = load_stored(*key)
    if kept is not None:
        return kept[0][::-1]
    image = materials.read_texture(path, mode)
    store_prepared(image[::-1], None, *key)       # as OpenGL wants it: the lowest row first
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
