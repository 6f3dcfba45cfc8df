"""What the kernel knows of a socket."""
import fcntl
import socket
import struct
import termios

_WAITING = struct.Struct('i')


def waiting_bytes(sock: socket.socket) -> int:
    """Return how many bytes wait in a socket to be read; 0 after the connection is closed."""
    try:
        return _WAITING.unpack(fcntl.ioctl(sock, termios.FIONREAD, _WAITING.pack(0)))[0]
    except (OSError, ValueError):
        return 0
