"""Arrays that are kept in the user's folder for caches, from one start to the next.

A file is an array as numpy writes it, and behind it what else there is to know of it, as JSON. It
is mapped into memory: what is not used of it is not read. The files can be deleted at any time.
"""
import concurrent.futures
import contextlib
import hashlib
import json
import os
import uuid
from typing import Any, Optional, Tuple

import numpy as np

from img_recog.files import cache_folder

_FOLDER = 'drawn_4'        # another number when the files change
MAX_BYTES = 2 << 30        # of all files; then those that were not used for longest are removed

# writing takes as long as reading: not while the first image is waited for
_writer = concurrent.futures.ThreadPoolExecutor(1)

Entry = Tuple[np.ndarray, Any]      # an array that cannot be changed, and what JSON can hold


def load(*key: Any) -> Optional[Entry]:
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


def store(array: np.ndarray, about: Any, *key: Any) -> None:
    """Keep an array and what is to know of it, if the disk has room for them.

    That is done in a thread. The array must not be changed.
    """
    _writer.submit(_write, cache_folder(_FOLDER), _name(key), array, about)


def wait() -> None:
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
