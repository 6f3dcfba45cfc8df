"""Keeps what was read from files, for as long as it is used."""
import os
from typing import Callable, Dict, Generic, Tuple, TypeVar

Value = TypeVar('Value')
_Key = Tuple[str, int, int]


class FileCache(Generic[Value]):
    """Reads each file once, and again when it has changed."""

    def __init__(self, read: Callable[[str], Value]):
        """read: returns what is in the file at a path."""
        self._read = read
        self._kept: Dict[_Key, Value] = {}
        self._used: Dict[_Key, Value] = {}

    def get(self, path: str) -> Value:
        """Return what is in a file; what `read` raises is not kept."""
        key = _key(path)
        if key not in self._used:
            self._used[key] = self._kept[key] if key in self._kept else self._read(path)
        return self._used[key]

    def forget_unused(self) -> None:
        """Keep only what `get` has returned since the last call of this."""
        self._kept, self._used = self._used, {}


def _key(path: str) -> _Key:
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return path, 0, 0
    return path, status.st_mtime_ns, status.st_size
