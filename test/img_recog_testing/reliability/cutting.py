"""Cuts the TCP connections of another process, from outside."""
import ctypes
import os
import socket

_PIDFD_OPEN, _PIDFD_GETFD = 434, 438        # the same numbers on all architectures
_LIBC = ctypes.CDLL(None, use_errno=True)


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
