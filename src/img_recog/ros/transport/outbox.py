"""Sending to the subscribers of a topic without ever blocking the publisher."""
import contextlib
import socket
import threading
import warnings
from queue import Empty, SimpleQueue
from typing import Callable, Iterable, NamedTuple, Optional, Tuple, Union

import rospy
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport

# After this time without work, the thread of an outbox ends. With a new thread each time, a frame
# whose images are viewed takes 9 % more CPU time at 1920x1080, and as much at 640x480.
_IDLE_S = 1.0


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
        # what it sends first, and how many bytes of it are sent already
        self._begun: 'SimpleQueue[Tuple[Packet, int]]' = SimpleQueue()
        self._has_thread = False

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
            self._begun.put((packet, count))
            with self._lock:
                if not self._has_thread:
                    self._has_thread = True
                    threading.Thread(target=self._run, args=(sock,), name='outbox',
                                     daemon=True).start()

    def _count(self, packet: Packet) -> None:
        """Count what is sent, for getBusStats of the node."""
        self._connection.stat_bytes += len(packet.data)
        self._connection.stat_num_msg += packet.messages

    def _run(self, sock: socket.socket) -> None:
        while True:
            try:
                packet, count = self._begun.get(timeout=_IDLE_S)
            except Empty:
                with self._lock:
                    if self._begun.empty():
                        self._has_thread = False
                        return
            else:
                self._catch_up(sock, packet, count)

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


def advertise(name: str, data_class: type, latch: bool = False,
              connect: Callable[[Callable[[], bool]], bool] = lambda add: add()
              ) -> rospy.Publisher:
    """Return a publisher without queues, whose connections have an Outbox each.

    They have it before rospy sends them the latched message.
    connect: is called for each new connection, with a function that adds it to the topic; returns
    what this returns.
    """
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', SyntaxWarning)      # about the missing queue
        publisher = rospy.Publisher(name, data_class, latch=latch, queue_size=None)
    topic = publisher.impl
    with topic.c_lock:
        if 'add_connection' not in vars(topic):     # not advertised in another place
            ordinary = topic.add_connection

            def add_connection(connection: TCPROSTransport) -> bool:
                _give_outbox(connection)
                return connect(lambda: ordinary(connection))
            topic.add_connection = add_connection
            for connection in topic.connections:
                _give_outbox(connection)
    return publisher


def send(packet: Packet, connections: Iterable[TCPROSTransport]) -> None:
    """Send a packet to connections of a publisher of `advertise`; close those that fail."""
    for connection in connections:
        try:
            connection.outbox.put(packet)
        except (OSError, TransportTerminated):      # like rospy
            _close(connection)


def _give_outbox(connection: TCPROSTransport) -> None:
    connection.outbox = Outbox(connection)
    connection.write_data = connection.outbox.write_data


def _close(connection: TCPROSTransport) -> None:
    """Close a connection to a subscriber, while rospy may be closing its topic."""
    with contextlib.suppress(TypeError):    # a closed topic has no list of listeners to notify
        connection.close()
