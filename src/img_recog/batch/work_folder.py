"""The folder with the results of the pieces of a run, until all are there."""
import contextlib
import functools
import hashlib
import io
import os
import pickle
from typing import Any, Sequence

from img_recog.batch import code_version
from img_recog.batch.work import Function
from img_recog.errors import UserError, one_line
from img_recog.files import atomic_write

_SUFFIX = '.piece'
_END_BYTES = 1 << 20
_ADVICE = 'set --output to where files can be written'


class WorkFolder:
    """A file for each result, named by all that it depends on.

    That is the function, its arguments, its input files, and the modules of this package. A file
    is recognized by its size, the time of its last change, and its first and last megabyte.

    path: of the folder, which is made when a result is written.
    """

    def __init__(self, path: str, function: Function):
        self.path = path
        self._common = (code_version.digest(), function.__module__, function.__qualname__)
        self._identity = functools.lru_cache(maxsize=None)(_identity)

    def name_of(self, files: Sequence[str], arguments: Sequence[Any]) -> str:
        """Return the name of the result of a piece; raise UserError if a file cannot be read."""
        content = io.BytesIO()
        pickler = pickle.Pickler(content, 4)
        pickler.fast = True         # else equal values that are two objects make a difference
        pickler.dump((self._common, tuple(map(self._identity, files)), tuple(arguments)))
        return hashlib.sha256(content.getvalue()).hexdigest()

    def has(self, name: str) -> bool:
        return os.path.isfile(self._path(name))

    def write(self, name: str, content: bytes) -> None:
        """Write the pickled result of a piece; raise UserError if that is not possible."""
        path = self._path(name)
        try:
            os.makedirs(os.path.dirname(path), exist_ok=True)
        except OSError as error:
            raise UserError('cannot write {}: {}'.format(path, one_line(error).lower()), _ADVICE)
        try:
            with atomic_write([path], _ADVICE) as (file,):
                file.write(content)
        except UserError:
            for folder in (os.path.dirname(path), self.path):
                with contextlib.suppress(OSError):      # it has other results
                    os.rmdir(folder)
            raise

    def read(self, name: str) -> Any:
        """Return the result of a piece."""
        with open(self._path(name), 'rb') as file:
            return pickle.load(file)

    def count(self) -> int:
        """Return how many results there are."""
        return sum(name.endswith(_SUFFIX) for _, _, names in os.walk(self.path) for name in names)

    def remove(self) -> None:
        """Remove all results, and the folder if it has nothing else."""
        for folder, folders, names in os.walk(self.path, topdown=False):
            for name in names:
                if name.endswith(_SUFFIX):
                    os.remove(os.path.join(folder, name))
            if not os.listdir(folder):
                os.rmdir(folder)

    def _path(self, name: str) -> str:
        # in 256 folders: atomic_write looks through all files beside the one that it writes
        return os.path.join(self.path, name[:2], name + _SUFFIX)


def _identity(path: str) -> str:
    try:
        with open(path, 'rb') as file:
            status = os.fstat(file.fileno())
            found = hashlib.sha256(file.read(_END_BYTES))
            file.seek(max(0, status.st_size - _END_BYTES))
            found.update(file.read(_END_BYTES))
    except OSError as error:
        raise UserError('cannot read {}: {}'.format(path, one_line(error).lower()))
    found.update('{} {}'.format(status.st_size, status.st_mtime_ns).encode())
    return found.hexdigest()
