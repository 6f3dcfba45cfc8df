"""The folder with the results of the pieces of a run, until all are there."""
import contextlib
import fcntl
import functools
import hashlib
import importlib.metadata
import io
import json
import os
import pathlib
import pickle
import platform
import stat
from typing import Any, Dict, List, Tuple, get_args, get_origin, get_type_hints

import cv2
import numpy as np

from img_recog.batch.work import Function, Piece
from img_recog.errors import UserError, one_line
from img_recog.files import atomic_write

_hints = functools.lru_cache(maxsize=None)(get_type_hints)
_SUFFIX = '.piece'
_END_BYTES = 1 << 20
# results of others may differ
_DISTRIBUTIONS = 'av', 'dask', 'distributed', 'moderngl', 'numpy', 'Pillow', 'pybullet', 'trimesh'
_ADVICE = 'set --output to where files can be written'


def dump_result(value: Any) -> bytes:
    """Return an npz of a value: of named tuples, lists, dicts, arrays, bytes and what JSON has.

    Its first array is the JSON, in which numbers stand for the others.
    """
    arrays: List[np.ndarray] = []
    text = json.dumps(_with_numbers(value, arrays)).encode()
    file = io.BytesIO()
    np.savez(file, np.frombuffer(text, np.uint8), *arrays)
    return file.getvalue()


def load_result(content: bytes, kind: Any) -> Any:
    """Return a value of a type, which names those of all its parts, as `dump` was given it.

    Raises errors of many types if that is not what the content is.
    """
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = [file[name] for name in file.files]
    return _of_kind(json.loads(arrays[0].tobytes().decode()), kind, arrays)


def _with_numbers(value: Any, arrays: List[np.ndarray]) -> Any:
    """Return a value with lists for all that has parts, and numbers for arrays."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (np.ndarray, bytes)):
        arrays.append(np.frombuffer(value, np.uint8) if isinstance(value, bytes) else value)
        return len(arrays)
    parts = list(value.items()) if isinstance(value, dict) else value
    return [_with_numbers(each, arrays) for each in parts] if isinstance(
        parts, (list, tuple)) else value


def _of_kind(value: Any, kind: Any, arrays: List[np.ndarray]) -> Any:
    """Return what `_with_numbers` was given; TypeError if it is of another type."""
    origin, kinds = get_origin(kind), get_args(kind)
    if kind in (np.ndarray, bytes):
        return arrays[value] if kind is np.ndarray else arrays[value].tobytes()
    if origin is dict:
        return dict(_of_kind(each, Tuple[kinds], arrays) for each in value)
    if origin is list or origin is tuple and kinds[-1] is ...:
        return origin(_of_kind(each, kinds[0], arrays) for each in value)
    if hasattr(kind, '_fields'):
        kinds = tuple(_hints(kind)[name] for name in kind._fields)
    if kinds:
        if len(value) != len(kinds):
            raise TypeError('{} parts, expected {}'.format(len(value), len(kinds)))
        parts = [_of_kind(*each, arrays) for each in zip(value, kinds)]
        return tuple(parts) if origin is tuple else kind(*parts)
    if type(value) is not kind and (kind is not float or type(value) is not int):
        raise TypeError('{} is no {}'.format(value, kind))
    return value


class WorkFolder:
    """A file for each result, named by all that it depends on.

    That is the function, its arguments, its input files, what those are made of, this package and
    the libraries.

    path: of the folder, which `lock` makes.
    """

    def __init__(self, path: str, function: Function):
        """function: its type of result names those of all parts, see `plain`.

        Raises UserError if other users could have put something there.
        """
        self.path = path
        self._kind = get_type_hints(function)['return']
        self._common = (versions(), function.__module__, function.__qualname__)
        _refuse_foreign(path)

    def name_of(self, piece: Piece) -> str:
        """Return the name of the result of a piece."""
        return digest((self._common, tuple(map(identity, piece.files)), piece.arguments,
                       piece.depends))

    def has(self, name: str) -> bool:
        """Return whether there is a result; one that is damaged is none."""
        try:
            self.read(name)
        except UserError:
            raise
        except Exception:       # it is missing, cut or empty: zipfile and numpy raise many types
            return False
        return True

    def write(self, name: str, result: Any) -> None:
        """Write the result of a piece; raise UserError if it is not possible."""
        path = self._path(name)
        try:
            for folder in (self.path, os.path.dirname(path)):
                os.makedirs(folder, 0o700, exist_ok=True)
                _refuse_foreign(folder)
        except OSError as error:
            raise UserError('cannot write {}: {}'.format(path, one_line(error).lower()), _ADVICE)
        with atomic_write([path], _ADVICE) as (file,):
            os.fchmod(file.fileno(), 0o600)
            file.write(dump_result(result))

    def read(self, name: str) -> Any:
        """Return the result of a piece."""
        path = self._path(name)
        for each in (os.path.dirname(path), path):
            _refuse_foreign(each)
        with open(path, 'rb') as file:
            return load_result(file.read(), self._kind)

    def count(self) -> int:
        """Return how many results there are."""
        return sum(name.endswith(_SUFFIX) for _, _, names in os.walk(self.path) for name in names)

    def remove(self) -> None:
        """Remove all results."""
        for folder, folders, names in os.walk(self.path, topdown=False):
            for name in names:
                if name.endswith(_SUFFIX):
                    os.remove(os.path.join(folder, name))
            if folder != self.path and not os.listdir(folder):
                os.rmdir(folder)

    def _path(self, name: str) -> str:
        # in 256 folders: atomic_write looks through all files beside the one that it writes
        return os.path.join(self.path, name[:2], name + _SUFFIX)


def lock(path: str) -> int:
    """Make a folder if there is none; return a descriptor that locks it until it is closed.

    Raises UserError if another program has locked it, or it cannot be made.
    """
    while True:
        _refuse_foreign(path)
        try:
            os.makedirs(path, 0o700, exist_ok=True)
            descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except FileNotFoundError:       # another program has ended meanwhile, and removed it
            continue
        except OSError as error:
            raise UserError('cannot write {}: {}'.format(path, one_line(error).lower()), _ADVICE)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            raise UserError('cannot use {}: another program that runs writes its results there'
                            .format(path), 'wait until it ends, or set --output to another')
        except OSError:         # a file system without locks
            pass
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), os.lstat(path)):
                return descriptor
        os.close(descriptor)


@functools.lru_cache(maxsize=None)
def versions() -> Dict[str, str]:
    """Return the versions of Python and libraries, and a hash of all modules of the package."""
    folder = pathlib.Path(__file__).resolve().parents[1]
    modules = hashlib.sha256()
    for path in sorted(folder.rglob('*.py')):
        modules.update(path.relative_to(folder).as_posix().encode() + b'\0' + path.read_bytes())
    found = {'img_recog': modules.hexdigest(), 'Python': platform.python_version(),
             'OpenCV': cv2.__version__}
    for name in _DISTRIBUTIONS:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def digest(value: Any) -> str:
    """Return a hash of plain values, tuples, dataclasses and arrays."""
    content = io.BytesIO()
    pickler = pickle.Pickler(content, 4)
    pickler.fast = True         # else equal values that are two objects make a difference
    pickler.dump(value)
    return hashlib.sha256(content.getvalue()).hexdigest()


def identity(path: str) -> str:
    """Return a hash of a file, or why it cannot be read.

    It is that of its content; of a file of more than 2 MB, that of its size, the times of its last
    change (the program that changes it can set one of them), and its first and last megabyte.
    """
    try:
        status = os.stat(path)
        return _identity(path, status.st_mtime_ns, status.st_size, status.st_ctime_ns)
    except OSError as error:
        return one_line(error)


@functools.lru_cache(maxsize=None)      # many pieces read the same file
def _identity(path: str, modified_ns: int, size: int, changed_ns: int) -> str:
    with open(path, 'rb') as file:
        found = hashlib.sha256(file.read(2 * _END_BYTES))
        if size > 2 * _END_BYTES:
            file.seek(size - _END_BYTES)
            found.update(file.read(_END_BYTES))
            found.update('{} {} {}'.format(size, modified_ns, changed_ns).encode())
    return found.hexdigest()


def _refuse_foreign(path: str) -> None:
    """Raise UserError if another user may have made what is at a path, or may change it."""
    try:
        status = os.lstat(path)
    except FileNotFoundError:
        return
    why = ('it is a link' if stat.S_ISLNK(status.st_mode)
           else 'it belongs to another user' if status.st_uid != os.geteuid()
           else 'others can write it' if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else '')
    if why:
        raise UserError('cannot use the results in {}: {}'.format(path, why),
                        'remove it, or set --output to a folder of your own')
