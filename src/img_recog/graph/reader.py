"""Reads nodes, topics and rates of the running system, without a node."""
import time
import xmlrpc.client
from collections import Counter
from typing import Any, Callable, Dict, FrozenSet, Iterable, List, NamedTuple, Optional, Tuple

import rosgraph

from img_recog.errors import UserError, one_line, shortened
from img_recog.ros.timed_xmlrpc import Master

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


_CALLER_ID = '/img_recog_graph'
_URI_ADVICE = 'set it to the address of the master, like http://localhost:11311'
_MASTER_ADVICE = 'start roscore or roslaunch first, or set ROS_MASTER_URI'

# for an edge, the number of messages on each of its connections
Counts = Dict[Edge, Dict[int, int]]


class _Sample(NamedTuple):
    time_s: float
    counts: Counts


class SystemReader:
    """Asks the master for nodes and topics, and the nodes for their numbers of messages.

    It subscribes to nothing, so it does not change what it shows: rates are the differences of
    what getBusStats of the nodes' XML-RPC interface says in two calls of `read`.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic, timeout_s: float = 1.0):
        """now: returns the time in s. timeout_s: of a call to a node.

        Raises UserError if ROS_MASTER_URI is no address.
        """
        self._now = now
        try:
            self._master = Master(rosgraph.Master(_CALLER_ID).master_uri, _CALLER_ID, timeout_s)
        except (ValueError, OSError):       # OSError: of another protocol than HTTP
            raise UserError('ROS_MASTER_URI is {!r}, expected http://HOST:PORT'.format(
                shortened(rosgraph.get_master_uri())), _URI_ADVICE)
        self._last: Dict[str, _Sample] = {}     # by the name of the node

    def read(self) -> System:
        """Return the system; with rates from the second call on.

        Raises UserError if the master does not answer.
        """
        try:
            state = self._master.state()
        except OSError as error:
            raise UserError('no master answers at {}: {}'.format(
                shortened(rosgraph.get_master_uri()), one_line(error)), _MASTER_ADVICE)
        edges = frozenset(Edge(node, topic, is_published)
                          for topics, is_published in ((state.published, True),
                                                       (state.subscribed, False))
                          for topic, nodes in topics.items() for node in nodes)
        samples = {node: answer for node, (_, answer) in self._master.ask_nodes(
            state.nodes, self._sample).items() if isinstance(answer, _Sample)}
        publishers = Counter(edge.topic for edge in edges
                             if edge.is_published and edge.node in samples)
        rates_hz = {edge: rate_hz for node, sample in samples.items()
                    for edge, rate_hz in _rates(self._last.get(node), sample, publishers)}
        self._last = samples
        return System(frozenset(state.nodes), edges, frozenset(state.nodes - set(samples)),
                      completed(edges, rates_hz))

    def _sample(self, node: str, proxy: Any) -> _Sample:
        """Return what a node says; runs in several threads."""
        try:
            return _Sample(self._now(), counts_in(node, proxy.getBusStats(_CALLER_ID)))
        except xmlrpc.client.Fault:     # rospy's, when a count does not fit in 32 bits
            return _Sample(self._now(), {})


def _rates(before: Optional[_Sample], now: _Sample, publishers: Dict[str, int]
           ) -> Iterable[Tuple[Edge, float]]:
    """Yield the edges of a node and their rates; publishers: their number, by topic."""
    if before is None or now.time_s <= before.time_s:
        return
    for edge, counts in now.counts.items():
        number = new_messages(edge, before.counts.get(edge, {}), counts)
        # of several connections of a subscriber, roscpp's getBusStats has only one
        if number is not None and (edge.is_published or len(counts) >= publishers[edge.topic]):
            yield edge, number / (now.time_s - before.time_s)


def counts_in(node: str, answer: Any) -> Counts:
    """Return the numbers of messages in the answer of getBusStats.

    >>> of_roscpp = [[['/odom', [[3, 4000, 3900, 12, 0]]]], []]
    >>> counts_in('/gazebo', of_roscpp) == {Edge('/gazebo', '/odom', is_published=True): {3: 12}}
    True
    """
    counts: Counts = {}
    # rospy answers [code, text, stats], roscpp with the stats alone
    stats = answer if isinstance(answer[0], list) else answer[2]
    for is_published, topics in zip((True, False), stats[:2]):
        for topic, *_, connections in topics:
            found = counts.setdefault(Edge(node, topic, is_published), {})
            for connection in connections:
                found[connection[0]] = _messages(connection, is_published)
    return counts


def _messages(connection: list, is_published: bool) -> int:
    # publishers: rospy has [id, bytes, messages, connected], roscpp [id, bytes, bytes of messages,
    # messages, 0]; subscribers, both: [id, bytes, messages, ...]
    return connection[3] if is_published and len(connection) > 4 else connection[2]


def new_messages(edge: Edge, before: Dict[int, int], now: Dict[int, int]) -> Optional[int]:
    """Return how many messages went over an edge; None if that is not known.

    before, now: the number of messages on each connection. A publisher sends each message on all
    of its connections, and a subscriber gets other messages on each.

    >>> new_messages(Edge('/gazebo', '/odom', is_published=True), {1: 5, 2: 5}, {1: 9, 2: 8})
    4
    >>> new_messages(Edge('/viewer', '/odom', is_published=False), {1: 5, 2: 5}, {1: 9, 2: 8})
    7
    """
    differences = [count - before[number] for number, count in now.items()
                   if count >= before.get(number, count + 1)]
    if not differences:
        return None
    return max(differences) if edge.is_published else sum(differences)


def completed(edges: Iterable[Edge], rates_hz: Dict[Edge, float]) -> Dict[Edge, float]:
    """Return the rates with those that follow from the other side of a topic.

    What all publishers send arrives at each subscriber, and what a subscriber gets is sent by the
    publisher if there is only one.

    >>> sent = Edge('/gazebo', '/odom', is_published=True)
    >>> got = Edge('/viewer', '/odom', is_published=False)
    >>> completed([sent, got], {got: 30.0}) == {sent: 30.0, got: 30.0}
    True
    """
    by_topic: Dict[str, Tuple[List[Edge], List[Edge]]] = {}
    for edge in edges:
        by_topic.setdefault(edge.topic, ([], []))[edge.is_published].append(edge)
    result = dict(rates_hz)
    for subscribers, publishers in by_topic.values():
        sent = [rates_hz.get(edge) for edge in publishers]
        got = [rates_hz[edge] for edge in subscribers if edge in rates_hz]
        if len(sent) == 1 and sent[0] is None and got:
            result[publishers[0]] = max(got)
        elif sent and None not in sent:
            for edge in subscribers:
                result.setdefault(edge, sum(rate_hz for rate_hz in sent if rate_hz is not None))
    return result
