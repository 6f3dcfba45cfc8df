"""A publisher for small messages at high rates."""
import select
import warnings

import rospy

from img_recog.ros.transport.switch import is_plain

_QUEUE_SIZE = 10        # with plain rospy


class DirectPublisher:
    """Publishes synchronously. A subscriber whose socket buffer is full misses the message.

    With a queue, rospy passes each message to a thread per subscriber, which takes four times
    as long as sending it; without one, a subscriber that does not read blocks the publisher
    forever. So this checks first which connections have room. Use it for messages much smaller
    than the buffer of a socket, and from one thread.
    """

    def __init__(self, name: str, data_class: type, latch: bool = False):
        """Advertise the topic `name`.

        latch: whether a new subscriber gets the last message.
        """
        self._is_plain = is_plain('direct_publisher')
        if self._is_plain:
            self._publisher = rospy.Publisher(name, data_class, latch=latch,
                                              queue_size=_QUEUE_SIZE)
        else:
            self._publisher = synchronous_publisher(name, data_class, latch)

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return self._publisher.get_num_connections()

    def publish(self, msg) -> None:
        """Send the message to all subscribers that have room for it."""
        if self._is_plain:
            self._publisher.publish(msg)
            return
        topic = self._publisher.impl
        connections = topic.connections
        ready = [each for each in connections if has_room(each.socket)]
        if len(ready) == len(connections):
            self._publisher.publish(msg)
            return
        topic.acquire()
        try:
            if topic.is_latch:
                topic.latch = msg
            for connection in ready:
                topic.publish(msg, connection_override=connection)
        finally:
            topic.release()


def synchronous_publisher(name: str, data_class: type, latch: bool = False) -> rospy.Publisher:
    """Return a publisher whose connections have no queue."""
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', SyntaxWarning)      # about the missing queue
        return rospy.Publisher(name, data_class, latch=latch, queue_size=None)


def has_room(sock) -> bool:
    """Return whether a socket accepts data without blocking; False if it is closed.

    sock: a socket.socket, or None, which rospy sets in a closed connection.
    """
    poll = select.poll()        # unlike select.select, it supports descriptors from 1024 on
    try:
        poll.register(sock, select.POLLOUT)
    except (TypeError, ValueError):
        return False
    return any(not event & select.POLLNVAL for _, event in poll.poll(0))
