"""The command line of doctor.py."""
import contextlib
import importlib
import io
import itertools
import os
import shlex
import socket
import struct
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Sequence, Set, Tuple

from img_recog.command_line import programs
from img_recog.command_line.messages import message
from img_recog.doctor import machine
from img_recog.doctor.machine import DEFAULT_MASTER, Fault, missing_packages
from img_recog.errors import most_similar, one_line, shortened
from img_recog.ros import timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master

_NAME = '/img_recog_doctor'
_TIMEOUT_S = 2.0
# of sensors: a node that subscribes to them waits for them
_SENSOR_PACKAGES = ('nav_msgs/', 'sensor_msgs/')
_TIME = struct.Struct('<II')
_TIME_AT = {'time': 4, 'std_msgs/Header': 8}    # of what begins with them, with its length
_MAX_AHEAD_S = 3600.0       # of a stamp; the clock of a simulation starts at 0
_ERRORS = (*timed_xmlrpc.ERRORS, ValueError, TypeError, IndexError)
Check = Callable[[], Iterator[Fault]]


class RunningSystem(NamedTuple):
    """Nodes and topics as the master and the nodes tell them.

    published, subscribed: the nodes of each topic. types: of each topic, by the node.
    dead: of each node that does not answer its address and the error.
    uris: of the others their addresses. is_sim_time: the parameter use_sim_time.
    """

    published: Dict[str, List[str]]
    subscribed: Dict[str, List[str]]
    types: Dict[str, Dict[str, str]]
    dead: Dict[str, Tuple[str, Exception]]
    uris: Dict[str, str]
    is_sim_time: bool

    def publishers(self, topic: str) -> List[str]:
        """Return the nodes that publish a topic and answer."""
        return [node for node in self.published.get(topic, ()) if node not in self.dead]


def check_running() -> Iterator[Fault]:
    """Report what is wrong with the running system, or that there is none."""
    uri = os.environ.get('ROS_MASTER_URI') or DEFAULT_MASTER
    try:
        system = _read(uri)
    except _ERRORS as error:
        yield Fault(
            message('no master answers at {}: {}', shortened(uri), one_line(error)),
            message('start "./run demo", roslaunch or roscore, or set ROS_MASTER_URI to the '
                    'master that runs; "./run shell" finds the demo of its folder'))
        return
    for check in (_dead_nodes, _clock, _types, _messages, _missing_publishers):
        yield from check(system)
    names = {kind.split('/')[0] for kinds in system.types.values() for kind in kinds.values()}
    yield from missing_packages(names)


def _read(uri: str) -> RunningSystem:
    with Master(uri, _NAME, _TIMEOUT_S) as master:
        state = master.state()
        answers = master.ask_nodes(state.nodes, _topics_of)
        is_sim_time = bool(master.ask('getParam', '/use_sim_time'))
    types: Dict[str, Dict[str, str]] = {}
    dead = {node: each for node, each in answers.items() if isinstance(each[1], Exception)}
    uris = {node: uri for node, (uri, _) in answers.items() if node not in dead}
    for node in uris:
        for topic, kind in answers[node][1]:
            if kind != '*':
                types.setdefault(topic, {})[node] = kind
    return RunningSystem(state.published, state.subscribed, types, dead, uris, is_sim_time)


def _topics_of(_: str, node: Any) -> List[Tuple[str, str]]:
    """Return the topics of a node with their types."""
    return [(str(topic), str(kind)) for answer in (
        node.getPublications(_NAME), node.getSubscriptions(_NAME)) for topic, kind in answer[2]]


def _dead_nodes(system: RunningSystem) -> Iterator[Fault]:
    for node, (uri, error) in sorted(system.dead.items()):
        if isinstance(error, socket.gaierror):
            advice = message('set ROS_IP on the computer of that node to its address and start '
                             'the node again, or add the name to /etc/hosts here')
        elif isinstance(error, ConnectionRefusedError):
            advice = message('it has ended without telling the master: "rosnode cleanup" '
                             'removes it')
        else:
            advice = message('it may be stopped, its computer switched off, or its ports closed '
                             'by a firewall; check ROS_IP there')
        yield Fault(message('the node {} does not answer at {}: {}', shortened(node),
                            shortened(uri), one_line(error)), advice)


def _clock(system: RunningSystem) -> Iterator[Fault]:
    clocks = system.publishers('/clock')
    if system.is_sim_time and not clocks:
        yield Fault(
            message('use_sim_time is set and nothing publishes /clock: time stands still'),
            message('start the simulator, or run "rosparam set /use_sim_time false" and start the '
                    'nodes again'))
    if clocks and not system.is_sim_time:
        yield Fault(
            message('{} publishes /clock, and /use_sim_time is not true: all other nodes have the '
                    'time of the computer', clocks[0]),
            message('run "rosparam set /use_sim_time true" and start the nodes again; in a launch '
                    'file, write the parameter with its slash'))
    if len(clocks) > 1:
        yield Fault(message('several simulators publish /clock: {}', ', '.join(sorted(clocks))),
                    message('stop all but one: "rosnode kill {}"',
                            shlex.quote(sorted(clocks)[-1])))
    others = set(system.uris) - {*clocks, *system.subscribed.get('/clock', ()), '/rosout'}
    if clocks and system.is_sim_time and others:
        yield Fault(message('these nodes have the time of the computer, not that of /clock: {}',
                            ', '.join(map(shortened, sorted(others)))),
                    message('they were started before /use_sim_time was set: start them again'))


def _types(system: RunningSystem) -> Iterator[Fault]:
    for topic, by_node in sorted(system.types.items()):
        kinds = sorted(set(by_node.values()))
        if len(kinds) > 1:
            yield Fault(
                message('the types of {} differ: {}', shortened(topic), '; '.join(
                    '{} ({})'.format(shortened(kind), ', '.join(sorted(
                        node for node in by_node if by_node[node] == kind))) for kind in kinds)),
                message('give one of these topics another name: NAME:=OTHER after rosrun, '
                        '<remap> in a launch file'))


def _messages(system: RunningSystem) -> Iterator[Fault]:
    """Compare what has subscribers: MD5 sums with those here, and stamps with /clock."""
    published = [(node, topic, by_node[node]) for topic, by_node in sorted(system.types.items())
                 if system.subscribed.get(topic) and len(set(by_node.values())) == 1
                 for node in system.publishers(topic) if node in by_node]
    with ThreadPoolExecutor(timed_xmlrpc.THREADS) as pool:
        heard = list(pool.map(lambda each: _hear(
            system.uris[each[0]], each[1],
            each[2] if system.is_sim_time and each[1] != '/rosout' else ''), published))
    now_s = {each[1]: time_s for each, (_, time_s) in zip(published, heard)}.get('/clock')
    for (node, topic, kind), (there, time_s) in zip(published, heard):
        here = getattr(_class_here(kind), '_md5sum', '')
        if here and there and there != here:
            yield Fault(
                message('{} publishes {} with another definition of {} than the one here '
                        '(MD5 sums {} and {})', *map(shortened, (
                            node, topic, kind, there, here))),
                message('build the package of the message again on both sides, from the same '
                        'version, and start the nodes again'))
        elif now_s and time_s > now_s + _MAX_AHEAD_S:
            yield Fault(
                message('{} publishes {} with the stamp {} s, and /clock says {} s', *map(
                    shortened, (node, topic)), *map('{:.3f}'.format, (time_s, now_s))),
                message('stamp messages with rospy.Time.now() or ros::Time::now()'))


def _class_here(kind: str) -> Any:
    """Return the class of a message type, None if there is none here."""
    package, _, name = kind.partition('/')
    with contextlib.suppress(Exception):        # of any kind: the module is of others
        return getattr(importlib.import_module(package + '.msg'), name)
    return None


def _hear(uri: str, topic: str, kind: str) -> Tuple[str, float]:
    """Return the MD5 sum that a publisher says, and the time in s in its next message.

    '' and 0 if there is none. No message is awaited if its type does not begin with a time.
    """
    md5sum, slots = '', getattr(_class_here(kind), '_slot_types', [])
    with contextlib.suppress(Exception):        # what does not answer is reported elsewhere
        from rosgraph import network
        with timed_xmlrpc.server(uri, _TIMEOUT_S) as node:
            answer: Any = node.requestTopic(_NAME, topic, [['TCPROS']])
        _, host, port = answer[2]
        with socket.create_connection((host, port), _TIMEOUT_S) as sock:
            network.write_ros_handshake_header(sock, {
                'callerid': _NAME, 'topic': topic, 'type': '*', 'md5sum': '*'})
            start = io.BytesIO()
            header = network.read_ros_handshake_header(sock, start, 4096)
            md5sum = str(header.get('md5sum', ''))
            at = _TIME_AT[slots[0]]
            data = start.getvalue()
            data += sock.makefile('rb').read(max(0, at + _TIME.size - len(data)))
            secs, nsecs = _TIME.unpack_from(data, at)
            return md5sum, secs + nsecs * 1e-9
    return md5sum, 0.0


def _missing_publishers(system: RunningSystem) -> Iterator[Fault]:
    for topic, nodes in sorted(system.subscribed.items()):
        kinds: Set[str] = set(system.types.get(topic, {}).values())
        if system.publishers(topic) or not kinds or topic == '/clock':
            continue
        if all(topic.startswith(node + '/') for node in nodes):
            continue        # what a node offers under its own name need not be used
        others = [other for other, by_node in system.types.items()
                  if system.publishers(other) and not system.subscribed.get(other)
                  and kinds.intersection(by_node.values())]
        similar = most_similar(topic, others)
        if similar:
            advice = message('did you mean {}? Add {}:={} after rosrun, or <remap> in a launch '
                             'file', *map(shortened, (similar, topic, similar)))
        else:
            advice = message('start the node that publishes it; "rostopic info {}" shows who '
                             'waits', shortened(topic))
        yield Fault(
            message('nothing publishes {}, which {} waits for', shortened(topic),
                    ', '.join(sorted(nodes))), advice,
            is_note=not similar and not any(kind.startswith(_SENSOR_PACKAGES) for kind in kinds))


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Print what is wrong and what to do; return 1 if there is more than notes, else 0."""
    return programs.run('doctor.py', _check, words=arguments)


def _check(words: List[str], _: object) -> str:
    parser = programs.parser(
        'doctor.py', 'Say what is wrong with this computer and with the running system, and what '
        'to do. The exit code is 1 if something is wrong, else 0.')
    parser.add_argument('--machine', action='store_true',
                        help='check the computer alone, while nothing runs')
    checks: List[Check] = [*machine.CHECKS]
    if not parser.parse_args(words).machine:
        checks.append(check_running)
    counts = [0, 0]
    # one by one, as each check takes a while
    for found in dict.fromkeys(itertools.chain.from_iterable(check() for check in checks)):
        counts[found.is_note] += 1
        programs.write('{}: {}\n    {}\n'.format(
            message('note' if found.is_note else 'problem'), found.problem, found.advice))
        sys.stdout.flush()
    if not any(counts):
        return message('nothing is wrong')
    summary = message('problems: {}, notes: {}', *counts)
    return programs.Incomplete(summary) if counts[False] else summary
