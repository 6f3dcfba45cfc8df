"""Files that are made once, and stay in the user's folder for caches."""
import hashlib
import os
import tempfile
from typing import Callable

from img_recog.errors import SimulationError, one_line
from img_recog.files import cache_folder


def kept(kind: str, content: bytes, suffix: str, make: Callable[[str], str]) -> str:
    """Return the path of the file that is made of some content; it is made if it is not there.

    kind: the folder in the cache; suffix: of the name. make: makes a file in the folder that it
    gets, and returns its path; what it raises is not kept.
    Raises SimulationError when the cache cannot be written.
    """
    folder = cache_folder(kind)
    path = os.path.join(folder, hashlib.sha256(content).hexdigest() + suffix)
    try:
        if not os.path.isfile(path):
            os.makedirs(folder, exist_ok=True)
            # another process may write the same file
            with tempfile.TemporaryDirectory(dir=folder) as own:
                os.replace(make(own), path)
    except OSError as error:
        raise SimulationError('cannot write to {}: {}'.format(folder, one_line(error)),
                              'set XDG_CACHE_HOME to a folder where files can be written')
    return path
