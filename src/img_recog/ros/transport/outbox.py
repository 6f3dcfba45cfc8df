"""Sending to the subscribers of a topic without ever blocking the publisher."""
import contextlib
import socket
import threading
from typing import Iterable, NamedTuple, Optional, Union

from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport


class Packet(NamedTuple):
    """Bytes on their way to subscribers, which must not change; messages: how many they are."""

    data: Union[bytes, memoryview]
    messages: int = 1


class Outbox:
    """Sends what the socket of a connection accepts at once, and the rest in a thread.

    While the thread sends the rest of a message, the newest message waits, like with
    queue_size=1. So a subscriber that is slow misses messages, but gets the last one; a subscriber
    that never reads keeps one thread and at most two messages. Call the methods from one thread
    at a time.
    """

    def __init__(self, connection: TCPROSTransport):
        self._connection = connection
        self._lock = threading.Lock()
        self._is_behind = False         # the thread is sending
        self._newest: Optional[Packet] = None       # what it sends next

    def write_data(self, data: bytes) -> bool:
        """Send a message; replaces `write_data` of the connection.

        Raises an exception if the connection is closed.
        """
        self.put(Packet(data))
        return True

    def put(self, packet: Packet) -> None:
        """Send a packet. Raises an exception if the connection is closed."""
        sock = self._connection.socket
        if sock is None:
            raise TransportTerminated('connection closed')
        if self._is_behind:
            with self._lock:
                if self._is_behind:
                    self._newest = packet
                    return
        count = 0
        with contextlib.suppress(BlockingIOError):
            count = sock.send(packet.data, socket.MSG_DONTWAIT)
        self._count(packet)
        if count < len(packet.data):
            self._is_behind = True
            threading.Thread(target=self._catch_up, args=(sock, packet, count), name='outbox',
                             daemon=True).start()

    def _count(self, packet: Packet) -> None:
        """Count what is sent, for getBusStats of the node."""
        self._connection.stat_bytes += len(packet.data)
        self._connection.stat_num_msg += packet.messages

    def _catch_up(self, sock: socket.socket, packet: Optional[Packet], count: int) -> None:
        """Send a packet without its first bytes, and then the newest one, until there is none."""
        while packet is not None:
            try:
                sock.sendall(memoryview(packet.data)[count:])
            except OSError:     # the connection is closed, by the subscriber or by us
                _close(self._connection)
            with self._lock:
                packet, self._newest = self._newest, None
                self._is_behind = packet is not None
            if packet is not None:
                self._count(packet)
            count = 0


def send(packet: Packet, connections: Iterable[TCPROSTransport]) -> None:
    """Send a packet to connections of an OutboxPublisher; close those that fail."""
    for connection in connections:
        try:
            connection.outbox.put(packet)
        except (OSError, TransportTerminated):      # like rospy
            _close(connection)


def _close(connection: TCPROSTransport) -> None:
    """Close a connection to a subscriber, while rospy may be closing its topic."""
    with contextlib.suppress(TypeError):    # a closed topic has no list of listeners to notify
        connection.close()
