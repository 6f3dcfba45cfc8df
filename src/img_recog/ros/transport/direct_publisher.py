"""A publisher for small messages at high rates."""
import select
import warnings

import rospy


class DirectPublisher:
    """Sends in the calling thread; those who do not keep up miss messages, as with a full queue.

    With a queue, rospy hands each message to a thread for each subscriber, which takes four times
    as long as the message; without one, a subscriber that hangs holds up the publisher for ever.
    This looks first whose connection has room. It is for messages much smaller than the buffer
    of a socket, and for one thread.
    """

    def __init__(self, name: str, data_class: type, latch: bool = False):
        with warnings.catch_warnings():
            warnings.simplefilter('ignore', SyntaxWarning)      # about the missing queue
            self._publisher = rospy.Publisher(name, data_class, latch=latch, queue_size=None)

    def get_num_connections(self) -> int:
        """Return how many subscribers there are."""
        return self._publisher.get_num_connections()

    def publish(self, msg) -> None:
        """Send the message to all subscribers that have room for it."""
        topic = self._publisher.impl
        connections = topic.connections
        ready = [each for each in connections if _has_room(each)]
        if len(ready) == len(connections):
            self._publisher.publish(msg)
            return
        topic.acquire()
        try:
            for connection in ready:
                topic.publish(msg, connection_override=connection)
        finally:
            topic.release()


def _has_room(connection) -> bool:
    try:
        return bool(select.select([], [connection.socket], [], 0)[1])
    except (OSError, TypeError, ValueError):        # being closed
        return False
