"""A publisher for small messages at high rates."""
import io
import warnings

import rospy
from rospy.exceptions import TransportTerminated
from rospy.msg import serialize_message

from img_recog.ros.transport.outbox import Outbox, close
from img_recog.ros.transport.switch import is_plain

_QUEUE_SIZE = 10        # with plain rospy
_LENGTH_BYTES = 4       # before each message on the wire


class _Serialized:
    """The bytes of a message, with the part of the interface of one that rospy needs."""

    def __init__(self, data: bytes):
        self._data = data

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to a buffer."""
        buff.write(self._data)


class DirectPublisher:
    """Publishes synchronously, and never blocks.

    With a queue, rospy passes each message to a thread per subscriber, which takes four times
    as long as sending it; without one, a subscriber that does not read blocks the publisher
    forever. Here an Outbox sends to each subscriber: one whose socket buffer is full misses
    messages and gets those that were published together last when it reads again.
    """

    def __init__(self, name: str, data_class: type, latch: bool = False):
        """Advertise the topic `name`.

        latch: whether a new subscriber gets the last message.
        """
        self._is_plain = is_plain('direct_publisher')
        self._buffer, self._count = io.BytesIO(), 0     # of the messages in the buffer
        if self._is_plain:
            self._publisher = rospy.Publisher(name, data_class, latch=latch,
                                              queue_size=_QUEUE_SIZE)
        else:
            self._publisher = synchronous_publisher(name, data_class, latch)
            self._adopt_connections(self._publisher.impl)

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return self._publisher.get_num_connections()

    def unregister(self) -> None:
        """Stop to advertise; nothing can be published any more."""
        self._publisher.unregister()

    def publish(self, msg) -> None:
        """Send a message to all subscribers that have room for it."""
        self.add(msg)
        self.flush()

    def add(self, msg) -> None:
        """Serialize a message, and send it with the next `flush`.

        To send several messages together takes much less time than one by one. The message may be
        changed then.
        """
        topic = self._publisher.impl
        lock = None if topic is None or self._is_plain else topic.publock
        if lock is None or topic.closed:
            self._publisher.publish(msg)        # raises an error unless it is plain
            return
        with lock:
            if not (topic.connections or topic.is_latch):
                return
            topic.seq += 1
            buffer, begin = self._buffer, self._buffer.tell()
            is_whole = False
            try:
                serialize_message(buffer, topic.seq, msg)
                is_whole = True
                self._count += bool(topic.connections)
                if topic.is_latch:
                    topic.latch = _Serialized(buffer.getvalue()[begin + _LENGTH_BYTES:])
            finally:
                # a part of a message would spoil all that follow
                if not (is_whole and topic.connections):
                    buffer.seek(begin)
                    buffer.truncate()

    def flush(self) -> None:
        """Send what was added since the last call."""
        buffer, topic = self._buffer, self._publisher.impl
        lock = None if topic is None else topic.publock     # None: rospy has closed the topic
        if lock is None:
            return
        with lock:
            data = buffer.getvalue()
            count, self._count = self._count, 0
            if not data:
                return
            buffer.seek(0)
            buffer.truncate()
            for connection in topic.connections:
                try:
                    connection.write_data(data, count)
                except (OSError, TransportTerminated):
                    close(connection)

    def _adopt_connections(self, topic) -> None:
        """Give an Outbox to each connection before rospy sends the latched message."""
        with topic.c_lock:
            if 'add_connection' in vars(topic):     # another DirectPublisher of this topic
                return
            add_connection = topic.add_connection

            def connect(connection):
                connection.write_data = Outbox(connection).write_data
                lock = topic.publock
                if lock is None:        # rospy has closed the topic
                    return add_connection(connection)
                # a new subscriber gets the latched message first, and once
                with lock:
                    self.flush()
                    return add_connection(connection)
            topic.add_connection = connect
            for connection in topic.connections:
                connection.write_data = Outbox(connection).write_data


def synchronous_publisher(name: str, data_class: type, latch: bool = False) -> rospy.Publisher:
    """Return a publisher whose connections have no queue."""
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', SyntaxWarning)      # about the missing queue
        return rospy.Publisher(name, data_class, latch=latch, queue_size=None)
