"""ROS 1 over plain sockets: subscribers and publishers that do what rospy never would.

They also do not depend on a master that has to stay alive, as a node of rospy does.
"""
import contextlib
import io
import socket
import struct
import threading
from typing import List, Optional, Tuple

from rosgraph import network

from img_recog.ros import timed_xmlrpc
from img_recog_helpers.waiting import DEADLINE_S
from img_recog_helpers.xmlrpc_server import XmlRpcServer

CALLER = '/test_wire'
_LENGTH = struct.Struct('<I')
_BUFFER_BYTES = 1 << 18
_MOST_PIECES = 64           # of one `read`: a publisher may send faster than it is read
# everything that a node or a master may do to a caller while it is stopped, started or killed
ERRORS = (*timed_xmlrpc.ERRORS, network.ROSHandshakeException, ValueError, EOFError)


def call(uri: str, method: str, *arguments, timeout_s: float = DEADLINE_S, caller: str = CALLER):
    """Call a method of a master or node; return its value. Raises one of ERRORS."""
    with timed_xmlrpc.Master(uri, caller, timeout_s) as called:
        return called.call(method, *arguments)


def answers(uri: str) -> bool:
    """Return whether a master or node answers."""
    try:
        call(uri, 'getPid')
    except ERRORS:
        return False
    return True


def node_uri(master: str, node: str, timeout_s: float = DEADLINE_S) -> str:
    """Return the address of the XML-RPC server of a node."""
    return call(master, 'lookupNode', node, timeout_s=timeout_s)


def pid_of(master: str, node: str) -> Optional[int]:
    """Return the process id of a node, None if it does not answer or the master does not."""
    try:
        return call(node_uri(master, node), 'getPid')
    except ERRORS:
        return None


def data_address(master: str, node: str, topic: str,
                 timeout_s: float = DEADLINE_S) -> Tuple[str, int]:
    """Return host and port where a node sends a topic."""
    protocol = call(node_uri(master, node, timeout_s), 'requestTopic', topic, [['TCPROS']],
                    timeout_s=timeout_s)
    if not protocol:
        raise ValueError('{} does not publish {}'.format(node, topic))
    return protocol[1], protocol[2]


def packet(msg) -> bytes:
    """Return what goes over the wire for a message."""
    buffer = io.BytesIO()
    msg.serialize(buffer)
    return framed(buffer.getvalue())


def framed(data: bytes) -> bytes:
    """Return what goes over the wire for the bytes of a message."""
    return _LENGTH.pack(len(data)) + data


class Subscription:
    """A connection to one publisher of a topic. It reads only when it is asked to."""

    def __init__(self, master: str, node: str, topic: str, data_class: type,
                 timeout_s: float = 1.0, buffer_bytes: Optional[int] = None,
                 caller: str = CALLER):
        """Connect; raises one of ERRORS.

        timeout_s: for each answer of the master and of the node.
        buffer_bytes: size of the receive buffer, to fill it sooner.
        caller: the name of this subscriber; of several with one name, rospy keeps the last.
        """
        self.topic, self.node, self._class = topic, node, data_class
        self._has_ended = False
        self.sock = socket.socket()
        try:
            if buffer_bytes is not None:
                self.sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
            self.sock.settimeout(timeout_s)
            self.sock.connect(data_address(master, node, topic, timeout_s))
            network.write_ros_handshake_header(self.sock, {
                'callerid': caller, 'topic': topic, 'type': data_class._type,
                'md5sum': data_class._md5sum, 'tcp_nodelay': '1'})
            # byte by byte: a latched message may come together with the answer, and stays in the
            # socket, on which users of this class wait
            answer = network.read_ros_handshake_header(self.sock, io.BytesIO(), 1)
            if 'error' in answer:
                raise ValueError(answer['error'])
            self._data = bytearray()
        except BaseException:
            self.sock.close()
            raise
        self.sock.setblocking(False)

    def read(self) -> list:
        """Return messages that have arrived; raises one of ERRORS at the end.

        These are all, unless they are more than 16 MB.
        """
        with contextlib.suppress(BlockingIOError):
            for _ in range(_MOST_PIECES):
                piece = self.sock.recv(_BUFFER_BYTES)
                self._data += piece
                self._has_ended = not piece
                if self._has_ended:
                    break
        messages, start = [], 0
        while start + 4 <= len(self._data):
            end = start + 4 + _LENGTH.unpack_from(self._data, start)[0]
            if len(self._data) < end:
                break
            messages.append(self._class().deserialize(bytes(self._data[start + 4:end])))
            start = end
        del self._data[:start]
        if self._has_ended and not messages:
            raise EOFError('{} has closed {}'.format(self.node, self.topic))
        return messages

    def close(self) -> None:
        self.sock.close()


class RawPublisher:
    """Publishes a topic, and sends to its subscribers any bytes at all.

    first: a message that each new subscriber gets.
    """

    def __init__(self, master: str, topic: str, data_class: type, caller: str = CALLER,
                 first=None):
        self._master, self.topic, self._caller = master, topic, caller
        self._begin = network.encode_ros_handshake_header({
            'callerid': caller, 'type': data_class._type, 'md5sum': data_class._md5sum,
            'message_definition': data_class._full_text, 'latching': '0', 'topic': topic})
        if first is not None:
            self._begin += packet(first)
        self._subscribers: List[socket.socket] = []
        self._listener = socket.create_server(('127.0.0.1', 0))
        address = ['TCPROS', *self._listener.getsockname()]
        self._node = XmlRpcServer(requestTopic=lambda *_: [1, '', address],
                                  dispatch=lambda *_: [1, '', 0])
        threading.Thread(target=self._accept, daemon=True).start()
        call(master, 'registerPublisher', topic, '*', self._node.uri, caller=caller)

    def _accept(self) -> None:
        while True:
            try:
                sock, _ = self._listener.accept()
            except OSError:         # closed
                return
            try:
                sock.settimeout(DEADLINE_S)
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                network.read_ros_handshake_header(sock, io.BytesIO(), 4096)
                sock.sendall(self._begin)
            except ERRORS:
                sock.close()
            else:
                self._subscribers.append(sock)

    def get_num_connections(self) -> int:
        return len(self._subscribers)

    def send(self, data: bytes) -> int:
        """Send bytes to all subscribers; return the number of them that took them."""
        count = 0
        for sock in list(self._subscribers):
            try:
                sock.sendall(data)
                count += 1
            except OSError:
                self._subscribers.remove(sock)
                sock.close()
        return count

    def publish(self, msg) -> int:
        """Send a message; return the number of subscribers that took it."""
        return self.send(packet(msg))

    def close(self) -> None:
        """Unregister and close everything."""
        with contextlib.suppress(*ERRORS):          # the master may have gone
            call(self._master, 'unregisterPublisher', self.topic, self._node.uri,
                 caller=self._caller)
        self._listener.close()
        while self._subscribers:
            self._subscribers.pop().close()
        self._node.stop()
