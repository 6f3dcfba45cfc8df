"""Incoming connections to the TCPROS port of a node, each in a thread with a time limit."""
import socket
import struct
import threading
import time
from collections import deque
from typing import Deque, Optional

import rospy
from rosgraph import network
from rospy.impl import tcpros_base

from img_recog.errors import one_line, shortened
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.ros.transport import xmlrpc_requests
from img_recog.ros.transport.switch import is_plain

_TIME_LIMIT_S = 5.0     # the other end may be on a busy machine, and may not try again
_MAX_HEADER_BYTES = 1 << 20     # it contains the definition of the message
_MAX_WAITING = 128              # connections without a complete header
_PAUSE_S = 0.1          # after a connection that could not be accepted
_LENGTH = struct.Struct('<I')


class HandshakeError(Exception):
    """A connection has sent no header of TCPROS; without a text if it has only been closed."""


class Handshakes:
    """Reads the header of each connection in a thread.

    rospy reads it in the thread that accepts connections, without a time limit: one connection
    that sends nothing keeps all subscribers and callers of services out. Here the header must be
    complete within _TIME_LIMIT_S. If too many connections wait, the oldest is closed: a subscriber
    sends its header at once.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._waiting: Deque[socket.socket] = deque()
        self._warn = ThrottledWarning()

    def accept(self, server: 'tcpros_base.TCPROSServer', sock: socket.socket, address) -> None:
        """Handle a new connection; return immediately. Replaces a method of rospy's server."""
        with self._lock:
            self._waiting.append(sock)
            oldest = self._waiting.popleft() if len(self._waiting) > _MAX_WAITING else None
        if oldest is not None:
            _shut_down(oldest)
        try:
            threading.Thread(target=self._handle, args=(server, sock, address),
                             daemon=True).start()
        except RuntimeError:        # no more threads
            self._leave(sock)
            sock.close()

    def _handle(self, server: 'tcpros_base.TCPROSServer', sock: socket.socket, address) -> None:
        try:
            header = _read_header(sock)
        except HandshakeError as error:
            problem: Optional[str] = str(error)
        except Exception:       # whatever was sent
            problem = 'it has sent no valid header of TCPROS'
        else:
            problem = _pass_on(server, sock, address, header)
        finally:
            self._leave(sock)
        if problem is None:
            return
        sock.close()
        if problem and not rospy.core.is_shutdown_requested():
            self._warn('connection from %s refused: %s', address[0], shortened(problem))

    def _leave(self, sock: socket.socket) -> None:
        with self._lock:
            if sock in self._waiting:
                self._waiting.remove(sock)


class _Listener(socket.socket):
    """Waits for connections; without file descriptors (EMFILE) it tries again later.

    rospy's thread ends with any error but a timeout, and no subscriber can connect again.
    """

    def accept(self):
        try:
            return super().accept()
        except OSError as error:
            if self.fileno() < 0:       # closed
                raise
            time.sleep(_PAUSE_S)
            raise socket.timeout(str(error)) from error


def install() -> None:
    """Limit the connections to both ports of this process. Call it before rospy.init_node."""
    if not is_plain('handshakes'):
        handshakes = Handshakes()
        tcpros_base.TCPROSServer._tcp_server_callback = (
            lambda server, sock, address: handshakes.accept(server, sock, address))
        create = tcpros_base.TCPServer._create_server_sock
        tcpros_base.TCPServer._create_server_sock = (
            lambda server: _Listener(fileno=create(server).detach()))
        xmlrpc_requests.install()


def _read_header(sock: socket.socket) -> dict:
    """Return the fields of the header, as rospy does.

    Raises HandshakeError, or another exception for a header that is not valid.
    """
    end_s = time.monotonic() + _TIME_LIMIT_S
    head = _receive(sock, _LENGTH.size, end_s)
    size, = _LENGTH.unpack(head)
    if size > _MAX_HEADER_BYTES:
        raise HandshakeError('its header has more than {} bytes'.format(_MAX_HEADER_BYTES))
    header = network.decode_ros_handshake_header(head + _receive(sock, size, end_s))
    sock.settimeout(None)
    return header


def _receive(sock: socket.socket, size: int, end_s: float) -> bytes:
    data = bytearray()
    while len(data) < size:
        # what has arrived is read after the end too: this thread may have waited, not the peer
        sock.settimeout(max(0., end_s - time.monotonic()))
        try:
            piece = sock.recv(min(size - len(data), 65536))
        except (BlockingIOError, socket.timeout):
            if time.monotonic() < end_s:
                continue
            raise HandshakeError('it has sent no complete header of TCPROS within {:g} s'.format(
                _TIME_LIMIT_S)) from None
        if not piece:
            raise HandshakeError()
        data += piece
    return bytes(data)


def _pass_on(server: 'tcpros_base.TCPROSServer', sock: socket.socket, address,
             header: dict) -> Optional[str]:
    """Give a connection to the topic or service in its header; return why that is not possible.

    None: it is in use now.
    """
    try:
        if 'topic' in header:
            problem = server.topic_connection_handler(sock, address, header)
        elif 'service' in header:
            problem = server.service_connection_handler(sock, address, header)
        else:
            problem = 'its header names no topic and no service'
        if not problem:
            return None
        if rospy.core.is_shutdown_requested():
            problem = 'node shutting down'
        network.write_ros_handshake_header(sock, {'error': problem})
    except Exception as error:      # as when the other end is gone
        problem = one_line(error)
    return problem


def _shut_down(sock: socket.socket) -> None:
    """End the reading of a connection, whose thread then closes it."""
    try:
        sock.shutdown(socket.SHUT_RDWR)
    except OSError:     # closed meanwhile
        pass
