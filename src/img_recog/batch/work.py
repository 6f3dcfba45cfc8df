"""A piece of work: what it is, and how a process does it."""
import contextlib
import functools
import os
import tempfile
from types import MappingProxyType
from typing import Any, Callable, Iterator, List, Mapping, NamedTuple, Sequence, Tuple

import cv2

from img_recog.errors import UserError, named_in_crashes, one_line
from img_recog.processes import memory

# Called with the paths of the files of a piece and its arguments. A function of a module: workers
# import it. The type of what it returns names those of all parts, see `plain`.
Function = Callable[..., Any]
# llvmpipe and numpy: there are as many processes as cores; with 0, llvmpipe draws in the thread
# that asks for it
_THREADS = {'LP_NUM_THREADS': '0', 'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1'}


class Piece(NamedTuple):
    """A part of the work.

    key: its name in reports. arguments: of the function; plain values, tuples, dataclasses and
    arrays. files: paths of the files that the function is given. size: how many frames or runs it
    is, for the progress. depends: a hash of what the result depends on besides. read: the
    `identity` of other files that the function reads, by their paths.
    """

    key: str
    arguments: Tuple[Any, ...]
    files: Tuple[str, ...] = ()
    size: int = 1
    depends: str = ''
    read: Mapping[str, str] = MappingProxyType({})


class Done(NamedTuple):
    """A piece that has run.

    result: None if there is a problem; is_lost: whether its process was, so that it may succeed
    another time.
    """

    piece: Piece
    result: Any
    problem: str
    is_lost: bool = False


def run_piece(function: Function, paths: Sequence[str], contents: Sequence[bytes],
              arguments: Sequence[Any]) -> Tuple[Any, str]:
    """Return the result of a piece, and in one line why there is none.

    contents: of the files, if they are not at `paths` on this machine.
    """
    _prepare()
    try:
        with _files(paths, contents) as found:
            return named_in_crashes(
                ' '.join([function.__name__, *paths]), function, found, *arguments), ''
    except UserError as error:
        return None, one_line(error)
    except Exception as error:      # of PyBullet or FFmpeg: the other pieces count
        return None, '{}: {}'.format(type(error).__name__, one_line(error))


@functools.lru_cache(maxsize=None)
def _prepare() -> None:
    """Prepare this process: once."""
    for name, threads in _THREADS.items():
        os.environ.setdefault(name, threads)
    cv2.setNumThreads(1)
    # Dask has its workers give memory back at once (MALLOC_TRIM_THRESHOLD_). Then the kernel maps
    # and clears that of each image anew, 100,000 pages for a loop of 15 s.
    memory.keep()


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
