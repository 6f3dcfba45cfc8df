"""ROS 1 over plain sockets: subscribers and publishers that do what rospy never would.

They also do not depend on a master that has to stay alive, as a node of rospy does.
"""
import io
import socket
import struct
import threading
import xmlrpc.client
from socketserver import ThreadingMixIn
from typing import Dict, List, Optional, Tuple
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

from img_recog import timed_xmlrpc
from img_recog_testing.waiting import DEADLINE_S

CALLER = '/reliability'
_LENGTH = struct.Struct('<I')
_MAX_HEADER_BYTES = 1 << 16
# everything that a node or a master may do to a caller while it is stopped, started or killed
ERRORS = (*timed_xmlrpc.ERRORS, ValueError, EOFError)


def call(uri: str, method: str, *arguments, timeout_s: float = DEADLINE_S):
    """Call a method of a master or node; return its value. Raises one of ERRORS."""
    with timed_xmlrpc.server(uri, timeout_s) as server:
        code, text, value = getattr(server, method)(CALLER, *arguments)
    if code != 1:
        raise ValueError('{} of {}: {}'.format(method, uri, text))
    return value


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


def data_address(master: str, node: str, topic: str,
                 timeout_s: float = DEADLINE_S) -> Tuple[str, int]:
    """Return host and port where a node sends a topic."""
    protocol = call(node_uri(master, node, timeout_s), 'requestTopic', topic, [['TCPROS']],
                    timeout_s=timeout_s)
    if not protocol:
        raise ValueError('{} does not publish {}'.format(node, topic))
    return protocol[1], protocol[2]


def pack_header(fields: Dict[str, str]) -> bytes:
    """Return a TCPROS header."""
    lines = ['{}={}'.format(*item).encode() for item in fields.items()]
    body = b''.join(_LENGTH.pack(len(line)) + line for line in lines)
    return _LENGTH.pack(len(body)) + body


def unpack_header(body: bytes) -> Dict[str, str]:
    """Return the fields of a TCPROS header without its length."""
    fields, begin = {}, 0
    while begin < len(body):
        end = begin + 4 + _LENGTH.unpack_from(body, begin)[0]
        name, _, value = body[begin + 4:end].decode(errors='replace').partition('=')
        fields[name], begin = value, end
    return fields


def packet(msg) -> bytes:
    """Return what goes over the wire for a message."""
    buffer = io.BytesIO()
    msg.serialize(buffer)
    return _LENGTH.pack(buffer.tell()) + buffer.getvalue()


def _receive(sock: socket.socket, size: int) -> bytes:
    data = b''
    while len(data) < size:
        piece = sock.recv(size - len(data))
        if not piece:
            raise EOFError('connection closed')
        data += piece
    return data


def _read_header(sock: socket.socket) -> Dict[str, str]:
    length = _LENGTH.unpack(_receive(sock, 4))[0]
    if length > _MAX_HEADER_BYTES:
        raise ValueError('a header of {} bytes'.format(length))
    return unpack_header(_receive(sock, length))


class Subscription:
    """A connection to one publisher of a topic. It reads only when it is asked to."""

    def __init__(self, master: str, node: str, topic: str, data_class: type,
                 timeout_s: float = 1.0, buffer_bytes: Optional[int] = None):
        """Connect; raises one of ERRORS.

        timeout_s: for each answer of the master and of the node.
        buffer_bytes: size of the receive buffer, to fill it sooner.
        """
        self.topic, self.node, self._class = topic, node, data_class
        self._data = b''
        self.sock = socket.socket()
        try:
            if buffer_bytes is not None:
                self.sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
            self.sock.settimeout(timeout_s)
            self.sock.connect(data_address(master, node, topic, timeout_s))
            self.sock.sendall(pack_header({
                'callerid': CALLER, 'topic': topic, 'type': data_class._type,
                'md5sum': data_class._md5sum, 'tcp_nodelay': '1'}))
            answer = _read_header(self.sock)
            if 'error' in answer:
                raise ValueError(answer['error'])
        except BaseException:
            self.sock.close()
            raise
        self.sock.setblocking(False)

    def read(self) -> list:
        """Return the messages that have arrived; raises one of ERRORS at the end."""
        try:
            while True:
                piece = self.sock.recv(1 << 18)
                if not piece:
                    raise EOFError('{} has closed {}'.format(self.node, self.topic))
                self._data += piece
        except BlockingIOError:
            pass
        messages = []
        while len(self._data) >= 4:
            end = 4 + _LENGTH.unpack_from(self._data)[0]
            if len(self._data) < end:
                break
            messages.append(self._class().deserialize(self._data[4:end]))
            self._data = self._data[end:]
        return messages

    def close(self) -> None:
        self.sock.close()


class _Server(ThreadingMixIn, SimpleXMLRPCServer):
    daemon_threads = True


class _Handler(SimpleXMLRPCRequestHandler):
    rpc_paths = ()          # any


class RawPublisher:
    """Publishes a topic, and sends to its subscribers any bytes at all."""

    def __init__(self, master: str, topic: str, data_class: type, caller: str = CALLER):
        self._master, self.topic, self._caller = master, topic, caller
        self._header = pack_header({
            'callerid': caller, 'type': data_class._type, 'md5sum': data_class._md5sum,
            'message_definition': data_class._full_text, 'latching': '0', 'topic': topic})
        self._subscribers: List[socket.socket] = []
        self._listener = socket.create_server(('127.0.0.1', 0))
        self._xmlrpc = _Server(('127.0.0.1', 0), _Handler, logRequests=False, allow_none=True)
        self._xmlrpc.register_function(self._request_topic, 'requestTopic')
        for name in ('publisherUpdate', 'paramUpdate', 'shutdown'):
            self._xmlrpc.register_function(lambda *_: [1, '', 0], name)
        self._xmlrpc.register_function(lambda *_: [1, '', 0], 'getPid')
        self._uri = 'http://127.0.0.1:{}/'.format(self._xmlrpc.server_address[1])
        for target in (self._xmlrpc.serve_forever, self._accept):
            threading.Thread(target=target, daemon=True).start()
        self.register()

    def register(self) -> None:
        """Tell the master about this topic."""
        with xmlrpc.client.ServerProxy(self._master) as master:
            master.registerPublisher(self._caller, self.topic, '*', self._uri)

    def _request_topic(self, *_):
        return [1, '', ['TCPROS', '127.0.0.1', self._listener.getsockname()[1]]]

    def _accept(self) -> None:
        while True:
            try:
                sock, _ = self._listener.accept()
            except OSError:         # closed
                return
            try:
                sock.settimeout(DEADLINE_S)
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                _read_header(sock)
                sock.sendall(self._header)
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

    def disconnect(self) -> None:
        """Close the connections to all subscribers."""
        while self._subscribers:
            self._subscribers.pop().close()

    def close(self) -> None:
        """Unregister and close everything."""
        try:
            with xmlrpc.client.ServerProxy(self._master) as master:
                master.unregisterPublisher(self._caller, self.topic, self._uri)
        except ERRORS:
            pass                # the master has gone
        self._listener.close()
        self.disconnect()
        self._xmlrpc.shutdown()
        self._xmlrpc.server_close()
