"""Which connections between running nodes are still missing."""
from typing import Any, Collection, Dict, List, NamedTuple, Set, Tuple

from img_recog import timed_xmlrpc
from img_recog.ros.master.calls import Master

_TIMEOUT_S = 1.0        # of a call to a node or the master


class Topics(NamedTuple):
    """What the master knows: the nodes that publish a topic, and those that subscribe to it."""

    publishers: Dict[str, List[str]]
    subscribers: Dict[str, List[str]]


class Connections:
    """Asks the master and the nodes. Raises OSError when the master does not answer."""

    def __init__(self, master_uri: str, node: str):
        """node: the name of this node."""
        self._master, self._node = Master(master_uri, node, _TIMEOUT_S), node

    def topics(self) -> Topics:
        """Return who publishes and who subscribes, by the names of topics."""
        published, subscribed, _ = self._master.ask('getSystemState') or ((), (), ())
        return Topics(dict(published), dict(subscribed))

    def topic_type(self, topic: str) -> str:
        """Return the type of the messages on a topic, '' if it is not known."""
        return dict(self._master.ask('getTopicTypes') or ()).get(topic, '')

    def missing_of(self, nodes: Collection[str]) -> List[str]:
        """Return what some nodes subscribe to and do not get yet, as 'NODE to TOPIC of NODE'.

        A node that does not answer is taken as one that is not connected to.
        """
        topics = self.topics()
        wanted = [(node, topic, publisher)
                  for topic, subscribers in topics.subscribers.items()
                  for node in subscribers if node in nodes
                  for publisher in topics.publishers.get(topic, ())]
        made = {publisher: self._made_by(publisher) for publisher in {each[2] for each in wanted}}
        return ['{} to {} of {}'.format(node, topic, publisher)
                for node, topic, publisher in sorted(wanted)
                if (topic, node) not in made[publisher]]

    def _made_by(self, publisher: str) -> Set[Tuple[str, str]]:
        """Return the topics on which a node sends, each with the node that it sends to."""
        uri = self._master.ask('lookupNode', publisher)
        if not uri:
            return set()
        try:
            answer = timed_xmlrpc.server(uri, _TIMEOUT_S).getBusInfo(self._node)
        except timed_xmlrpc.ERRORS:
            return set()
        return {(each[4], each[1]) for each in _connections(answer) if each[2] == 'o'}


def _connections(answer: Any) -> List[List[Any]]:
    """Return the rows of getBusInfo: [number, node, direction, transport, topic, ...].

    rospy answers [code, text, rows], an old roscpp the rows alone.
    """
    try:
        return answer if isinstance(answer[0], list) else answer[2]
    except (IndexError, TypeError):
        return []
