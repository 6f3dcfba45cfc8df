"""Requests to the XML-RPC server of a node, each with a limit of its time and size."""
import http
import io
import socket
import time
from typing import Optional

from rosgraph import xmlrpc

_TIME_LIMIT_S = 60.         # also without a request: callers keep connections, and connect again
_MAX_REQUEST_BYTES = 1 << 18       # values take 20 times their text, and memory stays in use
_PAUSE_S = 0.1              # after a connection that could not be accepted


class _Input(io.RawIOBase):
    """What a connection sends, until a request is too long or too slow."""

    def __init__(self, sock: socket.socket):
        super().__init__()
        self._sock, self._has_ended = sock, False
        self.begin()

    def begin(self) -> None:
        """Start the limits of the next request."""
        self._end_s, self._left = time.monotonic() + _TIME_LIMIT_S, _MAX_REQUEST_BYTES

    def readable(self) -> bool:
        """Return whether it can be read, for BufferedReader."""
        return True

    def readinto(self, buffer) -> int:
        """Receive bytes; return their number, 0 at the end. Raises socket.timeout at a limit."""
        left_s = self._end_s - time.monotonic()
        if self._has_ended:
            return 0
        try:
            if self._left <= 0 or left_s <= 0:
                raise socket.timeout('the request is too long or too slow')
            self._sock.settimeout(left_s)
            count = self._sock.recv_into(buffer)
        except OSError:
            self._has_ended = True      # SimpleXMLRPCServer would go on with the next request
            raise
        finally:
            self._sock.settimeout(_TIME_LIMIT_S)    # of the answer
        self._left -= count
        return count


class LimitedRequestHandler(xmlrpc.SilenceableXMLRPCRequestHandler):
    """Closes a connection that says nothing, and whose request is too long or too slow.

    rospy waits without limit: each such connection keeps a thread and a descriptor.
    """

    def setup(self) -> None:
        """Prepare the connection."""
        super().setup()
        self._input = _Input(self.connection)
        self.rfile = io.BufferedReader(self._input)

    def handle_one_request(self) -> None:
        """Read a request and answer it."""
        self._input.begin()
        super().handle_one_request()

    def decode_request_content(self, data: bytes) -> Optional[bytes]:
        """Return the request as it is; answer one that could expand, and return None.

        No ROS client packs its requests, or uses a DOCTYPE with entities.
        """
        if b'<!' not in data.replace(b'\0', b''):       # also as UTF-16
            return data
        self.send_response(http.HTTPStatus.BAD_REQUEST)
        self.send_header('Content-Length', '0')
        self.end_headers()
        return None


def install() -> None:
    """Use LimitedRequestHandler in this process, and survive EMFILE without load."""
    xmlrpc.SilenceableXMLRPCRequestHandler = LimitedRequestHandler
    xmlrpc.ThreadingXMLRPCServer.get_request = _get_request


def _get_request(server: xmlrpc.ThreadingXMLRPCServer):
    """Accept a connection. socketserver tries again at once, with all of a core."""
    try:
        return server.socket.accept()
    except OSError:
        time.sleep(_PAUSE_S)
        raise
