"""Messages for subscribers that come while somebody waits for an answer."""
import threading
from typing import Dict, List, Set, Tuple

from rospy.impl.tcpros_base import TCPROSTransport
from rospy.topics import _PublisherImpl

from img_recog.ros.transport.outbox import Packet, send


class Redelivery:
    """Sends packets of some topics, and keeps the last of each.

    A node that has ended and comes back subscribes before it can answer: a latched message would
    be answered too early. So `deliver` says when.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last: Dict[_PublisherImpl, Tuple[Packet, Set[TCPROSTransport]]] = {}

    def send(self, packet: Packet, topic: _PublisherImpl) -> None:
        """Send a packet to all subscribers of a topic, as `outbox.send` does."""
        with self._lock:
            connections = topic.connections
            self._last[topic] = packet, set(connections)
            send(packet, connections)

    def clear(self) -> None:
        """Keep nothing that was sent until now."""
        with self._lock:
            self._last = {}

    def is_needed(self) -> bool:
        """Return whether there are subscribers that the last packet of a topic was not sent to."""
        with self._lock:
            return any(self._others(topic) for topic in self._last)

    def deliver(self, to_all: bool = False) -> None:
        """Send the last packet of each topic to these subscribers, or again to all."""
        with self._lock:
            for topic, (packet, reached) in self._last.items():
                found = list(topic.connections or ()) if to_all else self._others(topic)
                reached.update(found)
                send(packet, found)

    def _others(self, topic: _PublisherImpl) -> List[TCPROSTransport]:
        reached = self._last[topic][1]
        return [each for each in topic.connections or () if each not in reached]
