"""Topics of real rospy without a master: its classes, over a pair of sockets."""
import io
import itertools
import socket
import struct
import threading

import pytest
import rospy
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub, TCPROSSub

from img_recog.ros.transport.switch import VARIABLE
from img_recog_testing.waiting import DEADLINE_S

_numbers = itertools.count()


def _set(monkeypatch, value):
    monkeypatch.setenv(VARIABLE, value)
    monkeypatch.setattr(rospy.topics, 'is_initialized', lambda: True)


@pytest.fixture(params=['', '1'], ids=['fast', 'plain'])
def way(request, monkeypatch):
    """For behavior: the fast way and the plain way must do the same."""
    _set(monkeypatch, request.param)
    return request.param


@pytest.fixture
def fast(monkeypatch):
    """For what only the fast way has: reused buffers, or what plain rospy does not do."""
    _set(monkeypatch, '')


@pytest.fixture
def name():
    """A topic of which no other test knows."""
    return '/topic_{}'.format(next(_numbers))


def packet(msg):
    """Return what goes over the wire for a message."""
    buffer = io.BytesIO()
    msg.serialize(buffer)
    return struct.pack('<I', buffer.tell()) + buffer.getvalue()


class SubscriberEnd:
    """A subscriber of another process: reads packets from its end of a pair of sockets."""

    def __init__(self, name, data_class):
        self._topic = rospy.topics.get_topic_manager().get_publisher_impl(name)
        self.sock, theirs = socket.socketpair()
        self.sock.settimeout(DEADLINE_S)
        self.transport = TCPROSTransport(TCPROSPub(name, data_class), name)
        self.transport.set_socket(theirs, '/subscriber_{}'.format(next(_numbers)))
        self._topic.add_connection(self.transport)

    def receive(self):
        """Return the next packet, with its length."""
        head = self._read(4)
        return head + self._read(struct.unpack('<I', head)[0])

    def _read(self, size):
        data = b''
        while len(data) < size:
            piece = self.sock.recv(size - len(data))
            assert piece
            data += piece
        return data

    def is_idle(self):
        """Return whether nothing has come."""
        self.sock.setblocking(False)
        try:
            return not self.sock.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return True
        finally:
            self.sock.settimeout(DEADLINE_S)


class PublisherEnd:
    """A publisher of another process: rospy reads in a thread what is sent here."""

    def __init__(self, name, data_class, begin=True, is_latched=False):
        self.topic = rospy.topics.get_topic_manager().get_subscriber_impl(name)
        self.sock, theirs = socket.socketpair()
        self.transport = TCPROSTransport(
            TCPROSSub(name, data_class, self.topic.queue_size, self.topic.buff_size,
                      self.topic.tcp_nodelay), name)
        self.transport.set_socket(theirs, '/publisher_{}'.format(next(_numbers)))
        self.transport.header, self.transport.is_latched = {'callerid': '/publisher'}, is_latched
        self.topic.add_connection(self.transport)
        self._thread = threading.Thread(target=self.transport.receive_loop,
                                        args=(self.topic.receive_callback,), daemon=True)
        if begin:
            self.begin()

    def begin(self):
        """Begin to read."""
        self._thread.start()

    def send(self, *messages):
        """Send messages in a thread."""
        self.send_bytes(b''.join(map(packet, messages)))

    def send_bytes(self, data):
        """Send data in a thread."""
        threading.Thread(target=self.sock.sendall, args=(data,), daemon=True).start()

    def join(self):
        """Wait until rospy reads no more."""
        self._thread.join(DEADLINE_S)
        assert not self._thread.is_alive()


@pytest.fixture
def close_later():
    """A list of ends, closed after the test."""
    ends = []
    yield ends
    for end in ends:
        end.transport.close()
        end.sock.close()


@pytest.fixture
def subscribe(close_later):
    """A function that subscribes to a topic of this process, as another process would."""
    def connect(name, data_class):
        close_later.append(SubscriberEnd(name, data_class))
        return close_later[-1]
    return connect


@pytest.fixture
def publish_to(close_later):
    """A function that connects a publisher to a topic of this process."""
    def connect(name, data_class, **options):
        close_later.append(PublisherEnd(name, data_class, **options))
        return close_later[-1]
    return connect
