"""A piece of work: what it is, and how a process does it."""
import contextlib
import os
import pickle
import tempfile
from typing import Any, Callable, Iterator, List, NamedTuple, Sequence, Tuple

import cv2

from img_recog.errors import UserError, one_line

# Called with the paths of the files of a piece and its arguments. A function of a module: workers
# import it.
Function = Callable[..., Any]
# llvmpipe and numpy: there are as many processes as cores
_ONE_THREAD = ('LP_NUM_THREADS', 'OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS')


class Piece(NamedTuple):
    """A part of the work.

    key: its name in reports, unique. arguments: of the function; plain values, tuples,
    dataclasses and arrays. files: paths of all files that the function reads. size: how many
    frames or runs it is, for the progress.
    """

    key: str
    arguments: Tuple[Any, ...]
    files: Tuple[str, ...] = ()
    size: int = 1


class Done(NamedTuple):
    """A piece that has run; content: its pickled result, if there is no problem."""

    piece: Piece
    content: bytes
    problem: str


def run_piece(function: Function, paths: Sequence[str], contents: Sequence[bytes],
              arguments: Sequence[Any]) -> Tuple[bytes, str]:
    """Return the pickled result of a piece, and in one line why there is none.

    contents: of the files, if they are not at `paths` on this machine.
    """
    for name in _ONE_THREAD:
        os.environ.setdefault(name, '1')
    cv2.setNumThreads(1)
    try:
        with _files(paths, contents) as found:
            return pickle.dumps(function(found, *arguments), 4), ''
    except UserError as error:
        return b'', one_line(error)
    except Exception as error:      # of PyBullet or FFmpeg: the other pieces count
        return b'', '{}: {}'.format(type(error).__name__, one_line(error))


@contextlib.contextmanager
def _files(paths: Sequence[str], contents: Sequence[bytes]) -> Iterator[List[str]]:
    if not contents:
        yield list(paths)
        return
    with tempfile.TemporaryDirectory(prefix='img_recog') as folder:
        found = []
        for number, (path, content) in enumerate(zip(paths, contents)):
            # the same name: it says of which type a file is
            found.append(os.path.join(folder, str(number), os.path.basename(path)))
            os.mkdir(os.path.dirname(found[-1]))
            with open(found[-1], 'wb') as file:
                file.write(content)
        yield found
