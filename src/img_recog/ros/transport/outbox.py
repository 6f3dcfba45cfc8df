"""Sending to one subscriber without ever blocking the publisher."""
import socket
import threading
from typing import Optional, Union

from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport


class Outbox:
    """Replaces `write_data` of a connection: sends what the socket accepts at once.

    While the socket is full, a thread sends the rest of the message that was begun, and after it
    the newest message, like with queue_size=1. So a subscriber that is slow misses messages, but
    gets the last one; a subscriber that never reads keeps one thread and at most two messages.
    rospy calls `write_data` from one thread at a time.
    """

    def __init__(self, connection: TCPROSTransport):
        self._connection = connection
        self._lock = threading.Lock()
        self._is_behind = False                     # the thread is sending
        self._newest: Optional[bytes] = None        # what it sends next

    def write_data(self, data: bytes) -> bool:
        """Send a message now or in the thread. Raises an exception if the connection is closed."""
        connection = self._connection
        sock = connection.socket
        if sock is None:
            raise TransportTerminated('connection closed')
        if self._is_behind:
            with self._lock:
                if self._is_behind:
                    self._newest = data
                    return True
        try:
            count = sock.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            count = 0
        if count < len(data):
            self._is_behind = True
            threading.Thread(target=self._catch_up, args=(sock, memoryview(data)[count:]),
                             daemon=True).start()
        connection.stat_bytes += len(data)
        connection.stat_num_msg += 1
        return True

    def _catch_up(self, sock: socket.socket, data: Optional[Union[bytes, memoryview]]) -> None:
        try:
            while data is not None:
                sock.sendall(data)
                with self._lock:
                    data, self._newest = self._newest, None
                    self._is_behind = data is not None
        except OSError:     # the connection is closed, by the subscriber or by us
            self._connection.close()
