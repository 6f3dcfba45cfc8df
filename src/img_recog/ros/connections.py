"""Which connections between running nodes are still missing."""
from typing import Any, Collection, Dict, List, Mapping, Optional, Sequence, Set, Tuple

from img_recog.errors import suggestion
from img_recog.ros import timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master

_TIMEOUT_S = 1.0        # of a call to a node or the master
_SHARED = ('/rosout', '/diagnostics', '/tf', '/tf_static')      # with a publisher in each node


class Connections:
    """Asks the master who publishes and subscribes, and the publishers whom they send to."""

    def __init__(self, master_uri: str, node: str):
        """node: the name of this node.

        uris: of the publishers that `missing` has followed when it found nothing, by their names;
        one that was started again has another.
        """
        self.uris: Dict[str, str] = {}
        self._master, self._node = Master(master_uri, node, _TIMEOUT_S), node
        self._heard: Set[str] = set()       # topics that were published when nothing was missing

    def missing(self, topics: Mapping[str, str], others: Collection[str] = ()) -> List[str]:
        """Return what is missing until this node hears of some topics, a phrase each.

        topics: the names, with the type that this node subscribes to, * for any.

        That is a publisher of each, its connection to this node, and its connections to all that
        it subscribes to; the same of the nodes that publish that, and so on. A topic of these
        that was published when nothing was missing must be published again. Nodes that do not
        answer do not count. others: nodes that must be there and be connected to all that they
        subscribe to, too.
        Raises OSError when the master does not answer.
        """
        state = self._master.state()
        publishers, known = state.published, state.nodes
        made: Dict[str, Optional[Set[Tuple[str, str]]]] = {}
        uris: Dict[str, str] = {}

        def alive(topic: str) -> List[str]:
            found = publishers.get(topic, ())
            for node in found:
                if node not in made:
                    uri = self._master.ask('lookupNode', node) or ''
                    made[node] = self._made_by(uri)
                    if made[node] is not None:
                        uris[node] = uri
            return [node for node in found if made[node] is not None]

        nodes = {self._node}
        wanted = [(self._node, topic) for topic in topics]

        def follow(new: Set[str]) -> None:
            wanted.extend((node, topic) for topic, subscribers in state.subscribed.items()
                          for node in subscribers if node in new - nodes)
            nodes.update(new)
        follow(set(others))
        for _, topic in wanted:         # it grows
            if topic not in _SHARED:
                follow(set(alive(topic)))
        missing = ['the node ' + node for node in others if node not in known]
        missing += [self._without_publisher(topic, publishers) for topic in dict.fromkeys(
            topic for _, topic in wanted if topic in topics or topic in self._heard)
            if not alive(topic)]
        for node, topic in wanted:
            missing += ['a connection of {} to {} of {}'.format(node, topic, publisher)
                        + (self._contradiction(topic, topics[topic]) if node == self._node else '')
                        for publisher in alive(topic)
                        if (topic, node) not in (made[publisher] or ())]
        if not missing:
            self.uris = uris
            self._heard.update(topic for _, topic in wanted if alive(topic))
        return missing

    def _without_publisher(self, topic: str, publishers: Mapping[str, Sequence[str]]) -> str:
        others = [each for each, nodes in publishers.items()
                  if each != topic and self._node not in nodes]
        question = '' if topic in self._heard else suggestion(topic, others)
        return 'a publisher of {}{}'.format(topic, question and ' ({})'.format(question))

    def _contradiction(self, topic: str, expected: str) -> str:
        found = dict(self._master.ask('getTopicTypes') or ()).get(topic, expected)
        return '' if expected in ('*', found) else ', which publishes {}, not {}'.format(
            found, expected)

    def own(self) -> Set[str]:
        """Return the topics that this node publishes. Raises OSError as `missing` does."""
        return {topic for topic, nodes in self._master.state().published.items()
                if self._node in nodes}

    def shared(self) -> List[Tuple[str, List[str]]]:
        """Return the topics that this node and others publish, apart from those made for it.

        Raises OSError when the master does not answer.
        """
        return [(topic, [each for each in nodes if each != self._node])
                for topic, nodes in self._master.state().published.items()
                if self._node in nodes and len(nodes) > 1 and topic not in _SHARED]

    def _made_by(self, uri: str) -> Optional[Set[Tuple[str, str]]]:
        """Return the topics on which a node sends, each with the node that it sends to.

        None if it does not answer.
        """
        try:
            answer = timed_xmlrpc.server(uri, _TIMEOUT_S).getBusInfo(self._node)
        except timed_xmlrpc.ERRORS:
            return None
        return {(each[4], each[1]) for each in _rows(answer) if each[2] == 'o'}


def _rows(answer: Any) -> List[List[Any]]:
    """Return the rows of getBusInfo: [number, node, direction, transport, topic, ...].

    rospy answers [code, text, rows].
    """
    try:
        return answer[2] if isinstance(answer[0], int) else answer
    except (IndexError, TypeError):
        return []
