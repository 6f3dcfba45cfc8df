"""Sending to one subscriber without ever blocking the publisher."""
import contextlib
import os
import socket
import threading
from queue import Empty, SimpleQueue
from typing import Dict, List, Tuple, Union

from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport

from img_recog.ros.transport.packets import Packet

_IDLE_S = 1.0       # after this time without work, the thread of an outbox ends
# A subscriber that the first bytes of a message wake up often has to wait for this processor, and
# to copy a larger message takes milliseconds. So it may read the first bytes first.
_LARGE_BYTES, _FIRST_BYTES = 1 << 21, 1 << 12


def close(connection: TCPROSTransport) -> None:
    """Close a connection to a subscriber, while rospy may be closing its topic."""
    with contextlib.suppress(TypeError):    # a closed topic has no list of listeners to notify
        connection.close()


class _Message:
    """Bytes that nobody changes, with the interface of a Packet. count: of the messages in it."""

    def __init__(self, data: bytes, count: int):
        self.data, self.count = data, count

    def retain(self) -> None:
        pass

    def release(self) -> None:
        pass


def _send(sock: socket.socket, data: Union[bytes, bytearray]) -> int:
    """Send what the socket accepts at once; return the number of bytes."""
    count = 0
    with contextlib.suppress(BlockingIOError):
        if len(data) >= _LARGE_BYTES:
            count = sock.send(memoryview(data)[:_FIRST_BYTES], socket.MSG_DONTWAIT)
            os.sched_yield()
        count += sock.send(memoryview(data)[count:], socket.MSG_DONTWAIT)
    return count


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
        self._newest: Union[_Message, Packet, None] = None      # what it sends next
        # what it sends first, and how many bytes of it are sent already
        self._begun: 'SimpleQueue[Tuple[Union[_Message, Packet], int]]' = SimpleQueue()
        self._has_thread = False

    def write_data(self, data: bytes, count: int = 1) -> bool:
        """Send this number of messages; replaces `write_data` of the connection.

        Raises an exception if the connection is closed.
        """
        self.put(_Message(data, count))
        return True

    def put(self, message: Union[_Message, Packet], leave_large: bool = False) -> None:
        """Send a message; as long as it is not sent, the outbox is an owner of it.

        leave_large: whether to leave all of a large message to the thread.
        Raises an exception if the connection is closed.
        """
        connection = self._connection
        sock = connection.socket
        if sock is None:
            raise TransportTerminated('connection closed')
        if self._is_behind:
            with self._lock:
                if self._is_behind:
                    message.retain()
                    replaced, self._newest = self._newest, message
                    if replaced is not None:
                        replaced.release()
                    return
        is_left = leave_large and len(message.data) >= _LARGE_BYTES
        count = 0 if is_left else _send(sock, message.data)
        self._count(message)
        if count < len(message.data):
            message.retain()
            self._is_behind = True
            self._begun.put((message, count))
            with self._lock:
                if not self._has_thread:
                    self._has_thread = True
                    threading.Thread(target=self._run, args=(sock,), daemon=True).start()

    def _count(self, message: Union[_Message, Packet]) -> None:
        """Count what is sent, for getBusStats of the node."""
        self._connection.stat_bytes += len(message.data)
        self._connection.stat_num_msg += message.count

    def _run(self, sock: socket.socket) -> None:
        while True:
            try:
                message, count = self._begun.get(timeout=_IDLE_S)
            except Empty:
                with self._lock:
                    if self._begun.empty():
                        self._has_thread = False
                        return
            else:
                self._catch_up(sock, message, count)

    def _catch_up(self, sock: socket.socket, message: Union[_Message, Packet, None],
                  count: int) -> None:
        """Send a message without its first bytes, and then the newest one, until there is none."""
        while message is not None:
            try:
                sock.sendall(memoryview(message.data)[count:])
            except OSError:     # the connection is closed, by the subscriber or by us
                close(self._connection)
            message.release()
            with self._lock:
                message, self._newest = self._newest, None
                self._is_behind = message is not None
            if message is not None:
                self._count(message)
            count = 0


class Outboxes:
    """An Outbox for each connection of a topic. Use it from one thread at a time."""

    def __init__(self) -> None:
        self._outboxes: Dict[TCPROSTransport, Outbox] = {}
        self._followed: List[TCPROSTransport] = []

    def follow(self, connections: List[TCPROSTransport]) -> None:
        """Add and remove outboxes, so that there is one for each of these connections.

        connections: rospy's list. Until the topic is closed, rospy replaces this list and never
        changes it.
        """
        if connections is not self._followed:
            self._followed = connections
            self._outboxes = {connection: self._outboxes.get(connection) or Outbox(connection)
                              for connection in connections}

    def put(self, packet: Packet, leave_large: bool) -> None:
        """Send a packet to all connections; `leave_large` is that of `Outbox.put`."""
        for connection, outbox in self._outboxes.items():
            try:
                outbox.put(packet, leave_large)
            except (OSError, TransportTerminated):      # like rospy
                close(connection)
