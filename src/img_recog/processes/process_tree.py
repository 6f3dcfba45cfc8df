"""All descendants of this process, including those whose parents have ended."""
import ctypes
import os
import signal
import subprocess
from typing import Any, Dict, Iterable, List, Union

PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36


def adopt_orphans() -> None:
    """Become the parent of descendants whose parent ends, in place of init.

    roslaunch starts each node in a separate session: without this, the nodes of a roslaunch that
    was killed could not be found.
    """
    _prctl(PR_SET_CHILD_SUBREAPER, 1)


def end_with_parent(signum: int = signal.SIGTERM) -> None:
    """Have the kernel send this process a signal when its parent ends, even if killed."""
    _prctl(PR_SET_PDEATHSIG, signum)


def _prctl(option: int, value: int) -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(option, ctypes.c_ulong(value)) != 0:
        raise OSError(ctypes.get_errno(), 'prctl')


def descendants() -> List[int]:
    """Return the ids of all descendants: children first, then grandchildren and so on."""
    children: Dict[int, List[int]] = {}
    for name in filter(str.isdigit, os.listdir('/proc')):
        try:
            state, parent = _fields(name)[:2]
        except OSError:         # the process has ended meanwhile
            continue
        if state not in 'ZX':
            children.setdefault(int(parent), []).append(int(name))
    found: List[int] = []
    generation = [os.getpid()]
    while generation:
        generation = [child for pid in generation for child in children.get(pid, ())]
        found += generation
    return found


def in_foreground(stream: Any) -> bool:
    """Return whether a stream is a terminal with this process, or its starter, in the foreground.

    roslaunch starts each node in a session of its own, which has no terminal.
    """
    try:
        process = os.getpid() if stream.isatty() else 0
        while process > 0:
            parent, group, _, terminal, foreground = map(int, _fields(process)[1:6])
            if terminal == os.fstat(stream.fileno()).st_rdev:
                return group == foreground
            process = parent
    except (AttributeError, OSError, ValueError):       # e.g. a closed stream
        pass
    return False


def _fields(process: Union[int, str]) -> List[str]:
    """Return what /proc says of a process from its state on: STATE PARENT GROUP SESSION ..."""
    # the kernel may cut a name within a character
    with open('/proc/{}/stat'.format(process), errors='replace') as file:
        # before the state are PID (NAME); the name may contain spaces and brackets
        return file.read().rpartition(')')[2].split()


def send(signum: int, pids: Iterable[int]) -> None:
    """Send a signal to those of the processes that still exist."""
    for pid in pids:
        try:
            os.kill(pid, signum)
        except ProcessLookupError:
            pass


def wait_or_kill(process: 'subprocess.Popen[bytes]', timeout_s: float) -> None:
    """Wait for the end of a child; kill it after a time."""
    try:
        process.wait(timeout_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def reap() -> Dict[int, int]:
    """Return the exit codes of all children that have ended, by process id."""
    codes: Dict[int, int] = {}
    while True:
        try:
            pid, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return codes
        if pid == 0:
            return codes
        codes[pid] = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
