"""Nodes and topics of a running system, and which of them a picture shows."""
from collections import Counter
from typing import Dict, FrozenSet, Iterable, NamedTuple, Tuple

# rqt_graph does not show the names that contain one of these unless "Debug" is chosen
DEBUG_NAMES = ('/clock', '/cpu_monitor', '/diag_agg', '/hd_monitor', '/monitor', '/pr2_dashboard',
               '/rosout', '/rqt', '/runtime_logger', '/rviz', '/rxloggerlevel', '/statistics')
TF_TOPICS = ('/tf', '/tf_static')
# of dynamic_reconfigure, which a picture shows both or not at all
_PARAMETER_TOPICS = ('/parameter_descriptions', '/parameter_updates')


class Edge(NamedTuple):
    """A node that publishes or subscribes to a topic."""

    node: str
    topic: str
    is_published: bool


class System(NamedTuple):
    """Nodes, topics and the edges between them.

    nodes: all that are registered; dead: those that do not answer.
    rates_hz: messages a second on an edge, where they are known.
    """

    nodes: FrozenSet[str]
    edges: FrozenSet[Edge]
    dead: FrozenSet[str] = frozenset()
    rates_hz: Dict[Edge, float] = {}

    @property
    def topics(self) -> FrozenSet[str]:
        """The topics that have an edge."""
        return frozenset(edge.topic for edge in self.edges)

    def without(self, node: str) -> 'System':
        """Return the system without a node, as without the one that shows the picture."""
        return self._replace(nodes=self.nodes - {node}, edges=frozenset(
            edge for edge in self.edges if edge.node != node))


def visible(system: System, leaves: bool = False) -> System:
    """Return the part of a system that rqt_graph shows. Its nodes may be without an edge.

    Names like /rosout and /clock, the topics of dynamic_reconfigure and nodes that do not answer
    are not shown; leaves: whether topics are that only one node uses or nobody subscribes to.

    >>> odom, clock = (Edge('/gazebo', topic, is_published=True) for topic in ('/odom', '/clock'))
    >>> rviz = Edge('/viewer', '/odom', is_published=False)
    >>> system = System(frozenset(['/gazebo', '/viewer']), frozenset([odom, clock, rviz]))
    >>> visible(system).edges == {odom, rviz}
    True
    """
    nodes, topics = _without_debug(system.nodes) - system.dead, _without_debug(system.topics)
    topics -= _parameter_topics(topics)
    if not leaves:
        topics -= _leaves(system.edges, topics)
    return system._replace(nodes=nodes, edges=frozenset(
        edge for edge in system.edges if edge.node in nodes and edge.topic in topics))


def _without_debug(names: Iterable[str]) -> FrozenSet[str]:
    return frozenset(name for name in names if not any(part in name for part in DEBUG_NAMES))


def _parameter_topics(topics: FrozenSet[str]) -> FrozenSet[str]:
    ends = [{topic[:-len(end)] for topic in topics if topic.endswith(end)}
            for end in _PARAMETER_TOPICS]
    return frozenset(node + end for node in set.intersection(*ends) for end in _PARAMETER_TOPICS)


def _leaves(edges: FrozenSet[Edge], topics: FrozenSet[str]) -> FrozenSet[str]:
    uses = Counter(edge.topic for edge in edges)
    subscribed = {edge.topic for edge in edges if not edge.is_published}
    return frozenset(topic for topic in topics if uses[topic] < 2 or topic not in subscribed)


def clusters_of(name: str) -> Tuple[str, ...]:
    """Return the two outer namespaces of a name, around which rqt_graph draws boxes.

    >>> clusters_of('/tb3_0/camera/rgb/image_raw')
    ('/tb3_0', '/tb3_0/camera')
    """
    parts = name.strip('/').split('/')[:-1][:2]
    return tuple('/' + '/'.join(parts[:number + 1]) for number in range(len(parts)))
