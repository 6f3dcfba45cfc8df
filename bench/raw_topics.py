"""Connections to topics without rospy, whose own work would be measured too."""
import contextlib
import socket
import struct
import threading
from typing import Iterator, Sequence, Union
from xmlrpc.client import ServerProxy

import rosgraph
from ros_processes import wait_for
from rosgraph import network

_NAME = '/raw_topics'
_TIMEOUT_S = 60.0
_LENGTH = struct.Struct('<I')
_BUFFER_BYTES = 1 << 20


def connect(topic: str, master_uri: str, poll_period_s: float = 0.1) -> socket.socket:
    """Return a connection to the first publisher of a topic; wait until there is one.

    poll_period_s: how often the master is asked.
    """
    master = rosgraph.Master(_NAME, master_uri=master_uri)

    def publisher():
        return next((nodes[0] for name, nodes in master.getSystemState()[0] if name == topic),
                    None)
    node = ServerProxy(master.lookupNode(wait_for(publisher, 'a publisher of ' + topic,
                                                  poll_period_s)))
    code, reason, protocol = node.requestTopic(_NAME, topic, [['TCPROS']])
    if code != 1:
        raise RuntimeError('{}: {}'.format(topic, reason))
    sock = socket.create_connection(tuple(protocol[1:3]), _TIMEOUT_S)
    sock.sendall(network.encode_ros_handshake_header(
        {'topic': topic, 'callerid': _NAME, 'md5sum': '*', 'type': '*', 'tcp_nodelay': '1'}))
    next(messages(sock))        # the header of the publisher
    return sock


def messages(sock: socket.socket) -> Iterator[memoryview]:
    """Yield the serialized messages that arrive; each is overwritten by the next one."""
    memory = bytearray()
    while True:
        size, = _LENGTH.unpack(_receive(sock, bytearray(_LENGTH.size)))
        if size > len(memory):
            memory = bytearray(size)
        yield _receive(sock, memoryview(memory)[:size])


def _receive(sock: socket.socket, memory: Union[bytearray, memoryview]
             ) -> Union[bytearray, memoryview]:
    """Fill the memory from a socket, and return it."""
    view = memoryview(memory)
    while view:
        count = sock.recv_into(view, 0, socket.MSG_WAITALL)
        if not count:
            raise RuntimeError('the publisher has closed the connection')
        view = view[count:]
    return memory


class Readers:
    """A context manager: subscribers to topics that drop the messages, each in a thread."""

    def __init__(self, topics: Sequence[str], master_uri: str):
        """Subscribe; wait until each topic has a publisher."""
        self._sockets = [connect(topic, master_uri) for topic in topics]
        self._threads = [threading.Thread(target=_drop, args=(sock,)) for sock in self._sockets]
        for thread in self._threads:
            thread.start()

    def __enter__(self) -> 'Readers':
        return self

    def __exit__(self, *_):
        for sock in self._sockets:
            with contextlib.suppress(OSError):      # closed by the publisher
                sock.shutdown(socket.SHUT_RDWR)     # its thread reads the end then
        for thread in self._threads:
            thread.join()


def _drop(sock: socket.socket) -> None:
    with sock, contextlib.suppress(OSError):
        while sock.recv(_BUFFER_BYTES):
            pass
