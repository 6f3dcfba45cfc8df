"""What the kernel knows of a socket."""
import fcntl
import socket
import struct
import termios

_WAITING = struct.Struct('i')
# of linux/netlink.h, sock_diag.h and inet_diag.h: nlmsghdr, then inet_diag_req_v2
_NETLINK_SOCK_DIAG, _SOCK_DIAG_BY_FAMILY, _NLM_F_REQUEST = 4, 20, 1
_REQUEST = struct.Struct('=IHHII BBHI 4s16s16sIQ')
_ALL_STATES, _NO_COOKIE = 0xffffffff, 0xffffffffffffffff
_QUEUE_OFFSET, _MAX_ANSWER = 16 + 4 + 48 + 4, 4096      # idiag_rqueue of inet_diag_msg


def waiting_bytes(sock: socket.socket) -> int:
    """Return how many bytes wait in a socket to be read; 0 after the connection is closed."""
    try:
        return _WAITING.unpack(fcntl.ioctl(sock, termios.FIONREAD, _WAITING.pack(0)))[0]
    except (OSError, ValueError):
        return 0


def unread_by_peer(sock: socket.socket) -> int:
    """Return how many bytes wait at the other end of a TCP connection on this computer.

    0 if the other end is elsewhere, or closed. The kernel is asked by sock_diag(7).
    """
    try:
        address, peer = sock.getsockname(), sock.getpeername()
        source, target = (socket.inet_pton(sock.family, each[0]) for each in (peer, address))
        with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, _NETLINK_SOCK_DIAG) as netlink:
            netlink.send(_REQUEST.pack(
                _REQUEST.size, _SOCK_DIAG_BY_FAMILY, _NLM_F_REQUEST, 0, 0, sock.family,
                socket.IPPROTO_TCP, 0, _ALL_STATES, struct.pack('!HH', peer[1], address[1]),
                source, target, 0, _NO_COOKIE))
            answer = netlink.recv(_MAX_ANSWER)
    except OSError:
        return 0
    _, kind = struct.unpack_from('=IH', answer)
    return (struct.unpack_from('=I', answer, _QUEUE_OFFSET)[0]
            if kind == _SOCK_DIAG_BY_FAMILY else 0)
