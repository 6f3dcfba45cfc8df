"""The other ends of a node's connections, over pairs of sockets and without a master."""
import contextlib
import fcntl
import itertools
import socket
import struct
import termios
import threading

import rospy
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSPub, TCPROSSub

from img_recog_helpers.waiting import DEADLINE_S
from img_recog_helpers.wire import packet

_numbers = itertools.count()


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
        head = self.read(4)
        return head + self.read(struct.unpack('<I', head)[0])

    def read(self, size):
        """Return so many of the next bytes."""
        data = b''
        while len(data) < size:
            piece = self.sock.recv(size - len(data))
            assert piece
            data += piece
        return data

    def fill(self):
        """Fill the buffer of the connection; return the number of bytes."""
        sock, count = self.transport.socket, 0
        sock.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                count += sock.send(bytes(4096))
        sock.setblocking(True)
        return count

    def is_idle(self):
        """Return whether nothing has come."""
        count, = struct.unpack('i', fcntl.ioctl(self.sock, termios.FIONREAD, bytes(4)))
        return count == 0


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
