"""Find the subscribers of this node that do not read."""
import select
import time
from typing import Any, List, Optional, Set, Tuple

from rospy.impl import registration

from img_recog.ros.transport.switch import is_plain

_WAIT_S = 0.1
Connection = Tuple[Any, Any]        # a topic and a connection of it, as rospy has them


class SubscriberCheck:
    """Checks the connections of all topics that the node publishes.

    A socket buffer may be full for a moment; a subscriber whose buffer stays full for 0.1 s at two
    checks in a row does not read, or is slower than the topic.
    """

    def __init__(self):
        self._full_before: Set[Tuple[str, str]] = set()

    def not_reading(self) -> Optional[Tuple[str, ...]]:
        """Return them as 'NODE (TOPIC)'; None if it cannot be known, with plain rospy.

        To be called once in each period.
        """
        if is_plain('subscribers'):
            return None
        full = {(connection.endpoint_id, topic.resolved_name)
                for topic, connection in _blocked(_connections())}
        found, self._full_before = full & self._full_before, full
        return tuple('{} ({})'.format(*each) for each in sorted(found))


def _connections() -> List[Connection]:
    return [(topic, connection)
            for topic in list(registration.get_topic_manager().pubs.values())
            for connection in topic.connections]


def _blocked(connections: List[Connection]) -> List[Connection]:
    """Return the connections whose socket stays full for a while."""
    poll = select.poll()        # unlike select.select, it supports descriptors from 1024 on
    waiting = {}
    for topic, connection in connections:
        try:
            poll.register(connection.socket, select.POLLOUT)
            waiting[connection.socket.fileno()] = topic, connection
        except (AttributeError, TypeError, ValueError, OSError):     # closed
            continue
    end_s = time.monotonic() + _WAIT_S
    while waiting:
        events = poll.poll(max(0.0, end_s - time.monotonic()) * 1000)
        if not events:
            break
        for descriptor, _ in events:
            poll.unregister(descriptor)
            waiting.pop(descriptor, None)
    return list(waiting.values())
