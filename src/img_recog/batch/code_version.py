"""Which versions run: results of others may differ."""
import contextlib
import functools
import hashlib
import importlib.metadata
import pathlib
import platform
from typing import Dict

import cv2

_DISTRIBUTIONS = 'av', 'dask', 'distributed', 'moderngl', 'numpy', 'Pillow', 'pybullet', 'trimesh'


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
