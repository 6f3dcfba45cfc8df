"""What processes use, from /proc: threads, descriptors, memory, connections."""
import ctypes
import os
import re
import signal
import socket
from typing import Dict, List, NamedTuple, Optional

_PIDFD_OPEN, _PIDFD_GETFD = 434, 438        # the same numbers on all architectures
_NAME = re.compile(r'__name:=([\w/]+)')
_LIBC = ctypes.CDLL(None, use_errno=True)
_PAGE_BYTES = os.sysconf('SC_PAGE_SIZE')


class Usage(NamedTuple):
    """What a process uses: numbers of threads and descriptors, resident memory in MB."""

    pid: int
    threads: int
    descriptors: int
    rss_mb: float


def marked(marker: str) -> Dict[int, str]:
    """Return the command lines of the processes that have inherited an environment entry.

    marker: the entry, 'NAME=value'. Zombies do not count.
    """
    found = {}
    for entry in filter(str.isdigit, os.listdir('/proc')):
        if int(entry) == os.getpid():
            continue
        try:
            with open('/proc/{}/environ'.format(entry), 'rb') as file:
                if marker.encode() not in file.read().split(b'\0'):
                    continue
            with open('/proc/{}/cmdline'.format(entry), 'rb') as file:
                line = file.read().replace(b'\0', b' ').decode(errors='replace').strip()
        except OSError:             # the process has ended, or belongs to another user
            continue
        if line:
            found[int(entry)] = line
    return found


def node_name(line: str) -> Optional[str]:
    """Return the name that roslaunch gave to a node, from its command line.

    None for another process, also for the one that starts the node again (scripts/respawn.py).
    """
    match = None if 'respawn.py' in line else _NAME.search(line)
    return match.group(1) if match else None


def nodes(marker: str) -> Dict[str, List[int]]:
    """Return the process ids of each node, by its name."""
    found: Dict[str, List[int]] = {}
    for pid, line in marked(marker).items():
        name = node_name(line)
        if name is not None:
            found.setdefault(name, []).append(pid)
    return found


def of(pid: int) -> Usage:
    """Return what a process uses; raises OSError if it has ended."""
    threads = len(os.listdir('/proc/{}/task'.format(pid)))
    descriptors = len(os.listdir('/proc/{}/fd'.format(pid)))
    with open('/proc/{}/statm'.format(pid)) as file:
        pages = int(file.read().split()[1])
    return Usage(pid, threads, descriptors, pages * _PAGE_BYTES / 1e6)


def age_s(pid: int) -> float:
    """Return the seconds since a process was started; raises OSError if it has ended."""
    with open('/proc/{}/stat'.format(pid)) as file:
        ticks = int(file.read().rpartition(')')[2].split()[19])
    with open('/proc/uptime') as file:
        return float(file.read().split()[0]) - ticks / os.sysconf('SC_CLK_TCK')


def is_alive(pid: int) -> bool:
    """Return whether a process runs; a zombie does not."""
    try:
        with open('/proc/{}/stat'.format(pid)) as file:
            return file.read().rpartition(')')[2].split()[0] not in 'ZX'
    except OSError:
        return False


def end_all(marker: str) -> None:
    """Kill all processes with this marker."""
    for pid in marked(marker):
        try:
            os.kill(pid, signal.SIGKILL)
        except OSError:
            pass


def why_not_cut() -> str:
    """Return why this machine does not allow `cut`, empty if it does."""
    try:
        with socket.socket() as sock:
            os.close(_duplicate(os.getpid(), sock.fileno()))
    except OSError as error:
        return '{}: {}'.format(error.strerror, os.strerror(error.errno))
    return ''


def cut(pid: int, reset: bool) -> int:
    """Cut all TCP connections of a process, as if its network had gone; return how many.

    reset: whether both ends get an error; otherwise both see the end of the stream.

    The process does not take part: its sockets are duplicated into this one. Listening sockets
    remain. Raises OSError.
    """
    count = 0
    for entry in os.listdir('/proc/{}/fd'.format(pid)):
        path = '/proc/{}/fd/{}'.format(pid, entry)
        try:
            if os.readlink(path).startswith('socket:'):
                with socket.socket(fileno=_duplicate(pid, int(entry))) as sock:
                    count += _cut(sock, reset)
        except OSError:
            if os.path.exists(path):
                raise               # else closed meanwhile
    return count


def _duplicate(pid: int, descriptor: int) -> int:
    """Return a duplicate, in this process, of a descriptor of another one.

    It needs Linux 5.6 and the rights of a debugger. Raises OSError with the name of the call.
    """
    pidfd = _system_call('pidfd_open', _PIDFD_OPEN, pid, 0)
    try:
        return _system_call('pidfd_getfd', _PIDFD_GETFD, pidfd, descriptor, 0)
    finally:
        os.close(pidfd)


def _system_call(name: str, *numbers: int) -> int:
    result = _LIBC.syscall(*numbers)
    if result < 0:
        raise OSError(ctypes.get_errno(), name)
    return result


def _cut(sock: socket.socket, reset: bool) -> int:
    if sock.family not in (socket.AF_INET, socket.AF_INET6) or sock.type != socket.SOCK_STREAM \
            or sock.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
        return 0
    try:
        sock.getpeername()
        if not reset:
            sock.shutdown(socket.SHUT_RDWR)
            return 1
    except OSError:                 # not connected
        return 0
    # connecting to no address ends a connection at once, and sends a reset to the other end
    return 1 if _LIBC.connect(sock.fileno(), b'\0' * 16, 16) == 0 else 0
