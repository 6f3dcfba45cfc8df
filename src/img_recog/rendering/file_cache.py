"""Keeps what was read from files, for as long as it is used."""
import os
from typing import Callable, Dict, Generic, Tuple, TypeVar

Value = TypeVar('Value')


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
