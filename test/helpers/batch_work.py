"""Functions for pieces of work, which processes of Dask import."""
import faulthandler
import os
import resource
import signal
import time
from typing import List

import distributed

from img_recog.errors import UserError

_WAIT_S = 60


def count_bytes(paths, factor) -> List[int]:
    """Return the sizes of files times a factor; a problem if it is 0, or a fault if None."""
    if factor == 0:
        raise UserError('the factor is 0', 'give another')
    return [factor * os.path.getsize(path) for path in paths]


def refused(paths) -> int:
    """Raise an error that names the file."""
    raise UserError('cannot read {}'.format(*paths))


def square(_, number, log='') -> int:
    """Return the square of a number; the name of a file to write says that it was computed."""
    if log:
        with open(os.path.join(log, str(number)), 'a') as file:
            file.write('x')
    return number * number


def changes(paths, number) -> int:
    """Return the number; a file is replaced by another of the same size and time before 3."""
    path = paths[0]
    if number == 3:
        status = os.stat(path)
        with open(path + '.new', 'w') as file:
            file.write('x' * status.st_size)
        os.utime(path + '.new', ns=(status.st_atime_ns, status.st_mtime_ns))
        os.replace(path + '.new', path)
    return number


def changes_by_itself(_, paths, number) -> int:
    """Do the same with files that the engine does not give."""
    return changes(paths, number)


def crashes(paths, number, mark) -> int:
    """Return the number; each process that is asked for 3 crashes, and the first for 6 is killed.

    mark: the path of a file that is written then.
    """
    if number == 3:
        faulthandler._sigsegv()
    if number == 6 and not os.path.exists(mark):
        with open(mark, 'w'):
            os.kill(os.getpid(), signal.SIGKILL)
    return number


def interrupted(_, number, folder) -> int:
    """Return the number; a Ctrl-C arrives before 3, as long as there is no file `go`."""
    if number == 3 and not os.path.exists(os.path.join(folder, 'go')):
        os.kill(os.getpid(), signal.SIGINT)
    return square(_, number, folder)


def process(_, number, folder, count) -> int:
    """Return the number of this process, as soon as `count` processes have begun such a piece.

    folder: where each process makes a file; another for each stage.
    """
    with open(os.path.join(folder, str(os.getpid())), 'w'):
        pass
    deadline = time.monotonic() + _WAIT_S
    while len(os.listdir(folder)) < count and time.monotonic() < deadline:
        time.sleep(0.01)
    return os.getpid()


def page_faults(_, number, buffers) -> int:
    """Return how many pages the kernel maps while buffers of 1 MB are used one after the other."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(buffers):
        bytearray(b'x') * 1000000
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before


def records(_, number) -> int:
    """Return how many records about pieces the worker has."""
    worker = distributed.get_worker()
    return max(len(worker.state.log), len(worker.state.stimulus_log),
               len(worker.transfer_outgoing_log))
