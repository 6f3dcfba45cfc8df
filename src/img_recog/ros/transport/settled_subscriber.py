"""A subscriber that knows whether it has passed on all that has arrived."""
import socket
import threading
from typing import Any, Callable, List, Mapping, Optional, Set, Tuple

import rospy
from rospy.impl.tcpros_base import TCPROSTransport

from img_recog.ros.transport.sockets import waiting_bytes
from img_recog.ros.transport.switch import is_plain


class SettledSubscriber:
    """Calls a function with each message and the header of its connection.

    type: the name of the type of the messages, * for any.

    What a publisher has sent on one topic before a message on another one is received by another
    thread, maybe later. `is_settled` tells when it was, if the publisher is on this computer: then
    what it has sent is in the socket at once.
    """

    def __init__(self, name: str, data_class: type,
                 callback: Callable[[Any, Mapping[str, str]], None], buff_size: int = 1 << 16):
        """Subscribe; `callback` is called in a thread of rospy.

        The header of a connection has the callerid of the publisher, the type of the messages and
        its message_definition. buff_size: at least that of a message.
        """
        self.type: str = getattr(data_class, '_type')
        self._subscriber = rospy.Subscriber(
            name, data_class, lambda msg: callback(msg, msg._connection_header),
            buff_size=buff_size, tcp_nodelay=True)
        self._watch: Optional[_Watch] = None
        if not is_plain('settled_subscriber'):
            topic = self._subscriber.impl
            with topic.c_lock:      # all subscribers of this process share the topic
                self._watch = vars(topic).get('watch') or _Watch(topic)

    def publishers(self) -> Set[str]:
        """Return the names of the nodes that are connected.

        Unlike `get_num_connections`, without those that were killed: rospy tries to reach them
        until another node of that name registers.
        """
        topic = self._subscriber.impl
        return {each.callerid_pub for each in (topic.connections if topic else None) or ()
                if each.socket is not None and not each.done}

    def unregister(self) -> None:
        """Unsubscribe."""
        self._subscriber.unregister()

    def is_settled(self) -> bool:
        """Return whether the callback has returned for all messages that had arrived."""
        return self._watch is None or self._watch.is_settled()


class _Watch:
    """Knows of all connections of a topic whether they are at work."""

    def __init__(self, topic: Any):
        """topic: `impl` of a Subscriber, whose c_lock is held."""
        topic.watch = self
        self._lock = threading.Lock()
        self._connections: List[Tuple[TCPROSTransport, threading.Event]] = []
        ordinary = topic.add_connection

        def add_connection(connection: TCPROSTransport) -> bool:
            self._add(connection)
            return ordinary(connection)
        topic.add_connection = add_connection
        for connection in topic.connections:
            self._add(connection)

    def is_settled(self) -> bool:
        with self._lock:
            connections = self._connections = [
                each for each in self._connections if not each[0].done]
        # in this order: a message that was read from the socket before is in the callback
        return not any(_has_unread(connection) or is_busy.is_set()
                       for connection, is_busy in connections)

    def _add(self, connection: TCPROSTransport) -> None:
        is_busy, ordinary = threading.Event(), connection.receive_once

        def receive_once() -> List[Any]:
            is_busy.clear()     # it returned from the callback
            sock = connection.socket
            try:
                if sock is not None and connection.read_buff.tell() == 0:
                    sock.recv(1, socket.MSG_PEEK)
            except OSError:     # the next call says it
                pass
            is_busy.set()
            return ordinary()
        connection.receive_once = receive_once
        with self._lock:
            self._connections.append((connection, is_busy))


def _has_unread(connection: TCPROSTransport) -> bool:
    sock = connection.socket
    return sock is not None and waiting_bytes(sock) > 0
