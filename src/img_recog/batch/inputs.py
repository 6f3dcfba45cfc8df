"""What a result depends on: values, files, and all that a world and a robot are read from."""
import functools
import hashlib
import io
import os
import pickle
import xml.etree.ElementTree as ElementTree
from typing import Any

from img_recog.errors import UserError, one_line
from img_recog.rendering import prepared
from img_recog.replay import scenario

_END_BYTES = 1 << 20


def digest(value: Any) -> str:
    """Return a hash of plain values, tuples, dataclasses and arrays."""
    content = io.BytesIO()
    pickler = pickle.Pickler(content, 4)
    pickler.fast = True         # else equal values that are two objects make a difference
    pickler.dump(value)
    return hashlib.sha256(content.getvalue()).hexdigest()


def identity(path: str) -> str:
    """Return a hash of a file; UserError if it cannot be read.

    It is that of its content; of a file of more than 2 MB, that of its size, the time of its last
    change, and its first and last megabyte.
    """
    try:
        status = os.stat(path)
        return _identity(path, status.st_mtime_ns, status.st_size)
    except OSError as error:
        raise UserError('cannot read {}: {}'.format(path, one_line(error).lower()))


@functools.lru_cache(maxsize=None)      # many pieces read the same file
def _identity(path: str, changed_ns: int, size: int) -> str:
    with open(path, 'rb') as file:
        found = hashlib.sha256(file.read(2 * _END_BYTES))
        if size > 2 * _END_BYTES:
            file.seek(size - _END_BYTES)
            found.update(file.read(_END_BYTES))
            found.update('{} {}'.format(size, changed_ns).encode())
    return found.hexdigest()


@functools.lru_cache(maxsize=None)      # a program reads them once
def of_scene(world: str, urdf: str) -> str:
    """Return a hash of what a world and a robot are once they are read, and of their files.

    world, urdf: as for scenario.build. What is included, expanded, found somewhere else, or not
    found any more makes another text, so only the files that the texts name are left.
    """
    try:
        file, robot, text = scenario.read(world, urdf)
    except UserError as error:      # what cannot be read has no result
        return one_line(error)
    urdfs = [robot.description.urdf, *(tree.urdf for tree in file.trees)]
    paths = {path for urdf in urdfs for element in ElementTree.fromstring(urdf).iter()
             for named in filter(os.path.isabs, element.attrib.values())
             for path in prepared.files_of(named)}
    return digest((text, urdfs[0], file, [
        (path, os.path.isfile(path) and identity(path)) for path in sorted(paths)]))
