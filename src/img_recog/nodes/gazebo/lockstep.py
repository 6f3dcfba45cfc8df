"""Lockstep: simulated time waits after each image until other nodes have answered it."""
import contextlib
import threading
import time
from dataclasses import dataclass
from functools import partial
from typing import (Any, Callable, Collection, Dict, FrozenSet, List, Mapping, Optional, Sequence,
                    Set, Tuple, Union)

import rosgraph
import rospy

from img_recog.conversions import robot_msgs
from img_recog.errors import SimulationError, UserError, one_line
from img_recog.nodes.gazebo.time_gate import TimeGate, Wait
from img_recog.ros.connections import Connections
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.ros.transport.settled_subscriber import SettledSubscriber
from img_recog.settings import Allowed, Settings, above, one_of, setting
from img_recog.simulation.sensors.robot_camera import CAMERA
from img_recog.simulation.simulated_model import Reading
from img_recog.simulation.simulator import Simulator

# kinds of sensors by the names that users give
_KINDS = {'image': CAMERA, 'scan': 'scan', 'odom': 'odometry', 'imu': 'imu',
          'joint_states': 'joint_states'}
_END = 'end'
_POLL_S, _MAX_SETTLING_S = 0.0001, 1.0
_CHECK_PERIOD_S = 1.0       # of wall time, between two looks for nodes that came back
_BUFFER_BYTES = 1 << 24     # an answer may be an image


@dataclass(frozen=True)
class LockstepSettings(Settings):
    """For whom simulated time waits.

    lockstep: topics, with spaces or commas between them, or none; after a message of the sensors
    in lockstep_sensors, time waits until an answer has come on each. lockstep_timeout: wall s
    without one, after which the node does what lockstep_at_timeout says.
    """

    lockstep: str = setting('none', Allowed('names of topics, or none', lambda text: bool(
        _words(text)) and all(map(rosgraph.names.is_legal_name, _words(text)))))
    lockstep_sensors: str = setting('image', Allowed(
        'some of ' + ', '.join(_KINDS),
        lambda text: bool(_words(text)) and set(_words(text)) <= set(_KINDS)))
    lockstep_timeout: float = setting(5.0, above(0))
    lockstep_at_timeout: str = setting('continue', one_of('continue', _END))

    @property
    def topics(self) -> Tuple[str, ...]:
        """The resolved names of the topics."""
        names = [] if self.lockstep == 'none' else _words(self.lockstep)
        return tuple(dict.fromkeys(map(rospy.resolve_name, names)))

    @property
    def kinds(self) -> FrozenSet[str]:
        """The kinds of sensors whose messages are answered."""
        return frozenset(_KINDS[name] for name in _words(self.lockstep_sensors))


def _words(text: str) -> List[str]:
    return text.replace(',', ' ').split()


class _Answers:
    """The messages on one topic. The lock of Lockstep is that of all attributes.

    Attributes:
        topic: Name of the topic.
        subscriber: Subscriber of the topic, None if its robot was removed.
        newest: Stamp of the last message, None if it has none.
        nodes: Names of the nodes that have published.
        is_given_up: Whether time goes on without them, until the next one comes.
    """

    def __init__(self, topic: str):
        self.topic, self.subscriber = topic, None       # type: str, Optional[SettledSubscriber]
        self.newest: Optional[rospy.Time] = None
        # replaced as a whole: the gate reads it for the log without the lock
        self.nodes: FrozenSet[str] = frozenset()
        self.is_given_up = False

    def __str__(self) -> str:
        return ' from '.join(filter(None, (self.topic, ', '.join(sorted(self.nodes)))))

    def publishers(self) -> Set[str]:
        """Return the names of the nodes that are connected."""
        return set() if self.subscriber is None else self.subscriber.publishers()

    def add(self, node: str, stamp: Optional[rospy.Time]) -> None:
        """Note a message."""
        self.newest, nodes = stamp, self.nodes | {node}
        # if there are several, some may have ended
        self.nodes = nodes & (self.publishers() | {node}) if len(nodes) > 1 else nodes

    def reason(self) -> str:
        """Return what there is instead of an answer."""
        known = ', '.join(sorted(self.nodes))
        if not self.publishers():
            return '{} is published by nobody{}'.format(
                self.topic, ' any more (before: {})'.format(known) if known else '')
        if not self.nodes:
            return '{} has had no message yet'.format(self.topic)
        return 'the last message on {}, of {}, {}'.format(
            self.topic, known, 'came before' if self.newest is None
            else 'has the stamp {:.3f} s'.format(self.newest.to_sec()))


class _AnsweringNodes:
    """The nodes between the sensors and the answers to them.

    It knows whether they are connected, and gives those that come back what they missed. All
    methods are for the loop.
    """

    def __init__(self, redelivery: Redelivery):
        self._redelivery = redelivery
        self._connections = Connections(rosgraph.get_master_uri(), rospy.get_name())
        self._uris: Dict[str, str] = {}         # of the nodes, by their names
        self._checked_s, self._is_renewed = 0.0, False

    def missing(self, answers: Collection[_Answers]) -> List[str]:
        """Return what is missing until the nodes get all that they subscribe to, and can answer.
        """
        try:
            return self._connections.missing({
                each.topic: each.subscriber.type for each in answers if each.subscriber})
        except OSError as error:
            return ['the master, which does not answer: ' + one_line(error)]

    def missing_at_start(self, answers: Collection[_Answers]) -> List[str]:
        """Return what `missing` returns; when nothing is, log a warning about other publishers.

        Raises UserError if a topic would be answered by this node itself.
        """
        with contextlib.suppress(OSError):
            own = sorted(self._connections.own() & {each.topic for each in answers})
            if own:
                raise UserError(
                    'lockstep: {} is published by the simulator itself'.format(', '.join(own)),
                    'name topics that are published by the nodes to wait for, such as cmd_vel')
        missing = self.missing(answers)
        if not missing:
            self._uris = self._connections.uris
            with contextlib.suppress(OSError):
                for topic, others in self._connections.shared():
                    rospy.logwarn('lockstep: %s is published by %s too: nodes answer their '
                                  'messages as well; stop them', topic, ', '.join(others))
        return missing

    def clear(self) -> None:
        """Forget what was sent: it is answered."""
        self._redelivery.clear()
        self._checked_s, self._is_renewed = time.monotonic(), False

    def deliver_again(self, answers: Collection[_Answers]) -> None:
        """Send what was not answered to nodes that came back; to be called again and again.

        One that hears only from other nodes has lost what these have sent. So, after a time in
        which what is on its way can arrive, all get the message of the sensors again.
        """
        now_s, is_needed = time.monotonic(), self._redelivery.is_needed()
        if not is_needed and now_s < self._checked_s + _CHECK_PERIOD_S:
            return
        self._checked_s = now_s
        if self._is_renewed:
            self._is_renewed = False
            self._redelivery.deliver(to_all=True)
        elif not self.missing(answers):
            uris = self._connections.uris
            self._is_renewed = not is_needed and any(
                self._uris.get(node) != uri for node, uri in uris.items())
            self._uris = {**self._uris, **uris}
            self._redelivery.deliver()


class Lockstep:
    """Tells the gate of simulated time which answers to messages of the sensors it waits for.

    An answer is a message with a header whose stamp is not older than that of the sensor's
    message or, where the type has no header, the next message after that one was sent. The
    command topics of the robots are subscribed to by `subscribe_commands`, all others here.

    The answers come in threads of rospy; all methods are for the loop.

    Attributes:
        is_on: Whether there are such topics; otherwise time waits for no answer, and commands
            are always due.
        kinds: Kinds of the sensors, empty if it is not on.
        redelivery: Sends their messages, None if it is not on.
    """

    def __init__(self, settings: LockstepSettings, gate: TimeGate, simulator: Simulator):
        """Have time wait until all nodes are connected."""
        self.is_on = bool(settings.topics)
        self.kinds = settings.kinds if self.is_on else frozenset()
        redelivery = Redelivery()
        self.redelivery = redelivery if self.is_on else None
        self._settings, self._gate, self._simulator = settings, gate, simulator
        self._lock = threading.Lock()       # of the answers and of _stamp
        self._answers = {topic: _Answers(topic) for topic in settings.topics}
        self._stamp = rospy.Time()          # of the messages to answer
        self._commands: Dict[str, SettledSubscriber] = {}
        self._nodes = _AnsweringNodes(redelivery)
        self._namespaces: Set[str] = set()      # of all robots, also of those that were removed
        self._is_due = self._is_reset = False   # commands are; the robots were, since they are
        self._warn = ThrottledWarning()
        gate.expect(Wait.CONNECTIONS, self._answers)

    def subscribe_commands(self, topic: str, data_class: type,
                           keep: Callable[[Any], None]
                           ) -> Union[SettledSubscriber, rospy.Subscriber]:
        """Subscribe to the commands of a robot, which may be answers; `keep` stores one."""
        if not self.is_on:
            return rospy.Subscriber(topic, data_class, keep, queue_size=10, tcp_nodelay=True)
        name = rospy.resolve_name(topic)
        answers = self._answers.get(name)

        def receive(msg: Any, header: Mapping[str, str]) -> None:
            keep(msg)       # first: an answer lets time go on
            if answers is not None:
                self._receive(answers, msg.header.stamp if hasattr(msg, 'header') else None,
                              header.get('callerid', ''))
        if answers is not None and answers.subscriber is not None:
            answers.subscriber.unregister()
        made = self._commands[name] = SettledSubscriber(name, data_class, receive)
        if answers is not None:
            answers.subscriber = made
        return made

    def forget(self, namespace: str) -> None:
        """Expect no answers from the namespace of a robot that is removed."""
        place = rospy.resolve_name(namespace)
        for topic in [each for each in self._commands if _is_within(each, place)]:
            del self._commands[topic]
            if topic in self._answers:
                self._answers[topic].subscriber = None
        self._gate.end(Wait.ANSWERS, *(
            each for each in self._answers.values() if _is_within(each.topic, place)))

    def check(self, kinds: Collection[str]) -> None:
        """Raise SimulationError if a robot with sensors of these kinds has none to answer."""
        if self.is_on and not self.kinds & set(kinds):
            raise SimulationError(
                'lockstep waits for answers to {}, but the robot has no such sensor'.format(
                    self._settings.lockstep_sensors),
                'start with camera:=robot, or set lockstep_sensors to some of {}'.format(
                    ', '.join(name for name, kind in _KINDS.items() if kind in kinds)))

    def subscribe(self) -> None:
        """Subscribe to the topics that are no command topics of the robots that are there."""
        for name, answers in self._answers.items():
            if answers.subscriber is None:
                answers.subscriber = SettledSubscriber(
                    name, rospy.AnyMsg, partial(self._receive_any, answers), _BUFFER_BYTES)

    def _receive_any(self, answers: _Answers, msg: rospy.AnyMsg, header: Mapping[str, str]
                     ) -> None:
        stamp = robot_msgs.stamp_in(msg._buff, header.get('type', ''),
                                    header.get('message_definition', ''))
        self._receive(answers, stamp, header.get('callerid', ''))

    def _receive(self, answers: _Answers, stamp: Optional[rospy.Time], node: str) -> None:
        """Take a message; runs in a thread of rospy."""
        topic, newest = answers.topic, rospy.get_rostime()
        with self._lock:
            answers.add(node, stamp)
            is_answer = answers in self._gate.awaited(Wait.ANSWERS)
            if is_answer:
                newest = max(newest, self._stamp)
                is_answer = (self._gate.is_sent if stamp is None
                             else stamp >= self._stamp)
            was_given_up, answers.is_given_up = answers.is_given_up, False
            is_extra = stamp is None and not (
                is_answer or was_given_up or self._gate.awaited(Wait.CONNECTIONS))
            nodes = sorted(answers.nodes)
            if is_answer:
                self._gate.end(Wait.ANSWERS, answers)
        if was_given_up:
            rospy.loginfo('lockstep: %s answers on %s again: simulated time waits for it', node,
                          topic)
        if len(nodes) > 1:
            self._warn(
                'lockstep: %s publish on %s: the first message of any of them counts as the '
                'answer; leave one', ', '.join(nodes), topic)
        elif is_extra:
            self._warn(
                'lockstep: %s publishes more than one message on %s for a message of the sensors: '
                'which one counts as the answer depends on the machine; publish one, or have time '
                'wait for a topic whose messages have a header', node, topic)
        if stamp is not None and stamp > newest:
            self._warn(
                'lockstep: the answer of %s on %s has the stamp %.3f s, but it is %.3f s: give it '
                'the stamp of the message that it answers', node, topic, stamp.to_sec(),
                rospy.get_rostime().to_sec())

    def expect(self, readings: Sequence[Reading], namespaces: Callable[..., Sequence[str]]
               ) -> None:
        """Expect answers to the readings that are published next.

        A topic in the namespace of a robot answers the sensors of this robot, any other one those
        of all.

        Args:
            readings: Readings of all sensors.
            namespaces: Function that returns the namespaces of the robots with some names, or of
                all.
        """
        answered = self.is_on and [each for each in readings if each.kind in self.kinds]
        if not answered:
            return
        self._is_due = True
        self._nodes.clear()
        measured = _resolved(namespaces({each.robot for each in answered}))
        self._namespaces |= _resolved(namespaces())
        expected = []
        with self._lock:
            self._stamp = robot_msgs.stamp_of(answered[-1].time_s)
            for answers in self._answers.values():
                owners = {each for each in self._namespaces if _is_within(answers.topic, each)}
                if not answers.is_given_up and (not owners or owners & measured):
                    expected.append(answers)
            self._gate.expect(Wait.ANSWERS, expected)
        if all(each.kind != CAMERA for each in answered):
            self._gate.notify_sent()

    def look(self) -> bool:
        """Look for nodes, and for answers that are late; return whether time waits for none.

        Raises UserError when no answer came in time and lockstep_at_timeout is end.
        """
        gate, answers = self._gate, self._answers.values()
        if not self.is_on or gate.awaited(Wait.LOADING, Wait.IMAGES):
            return False
        gate.notify_sent()      # also of images that can never be drawn
        if gate.awaited(Wait.CONNECTIONS):
            gate.expect(Wait.CONNECTIONS, self._nodes.missing_at_start(answers))
        if gate.awaited(Wait.CONNECTIONS):
            return False
        late = gate.overdue()
        if late:
            self._give_up(late)
        missing = gate.awaited(Wait.ANSWERS)
        if missing:
            self._nodes.deliver_again(missing)
        return not missing

    def look_for_sensor(self) -> None:
        """Look whether there is a sensor to answer."""
        is_there = self._simulator.next_reading(self.kinds) is not None
        self._gate.expect(Wait.SENSOR, () if is_there else [self._settings.lockstep_sensors])

    def end_of(self, end: int) -> int:
        """Return the step at which to stop, at most `end`: where answers are expected."""
        step = self._simulator.next_reading(self.kinds) if self.is_on else None
        return end if step is None else min(end, step)

    def take_due(self, discard: Callable[[], None]) -> bool:
        """Return whether commands are due: once after the answers.

        It waits for those that were sent before the answers. After a reset they are out of date:
        `discard` drops them.
        """
        if not self._is_due:
            return not self.is_on
        end_s = time.monotonic() + _MAX_SETTLING_S
        while (not all(each.is_settled() for each in self._commands.values())
               and time.monotonic() < end_s):
            time.sleep(_POLL_S)
        if self._is_reset:
            discard()
        self._is_due = self._is_reset = False
        return True

    def notify_reset(self) -> None:
        """Call when the robots are reset: the commands that will answer are out of date."""
        self._is_reset = self._is_due

    def _give_up(self, late: Collection[_Answers]) -> None:
        with self._lock:
            reasons = [each.reason() for each in self._answers.values() if each in late]
        line = 'lockstep: no answer in {:g} s to what was measured at {:.3f} s: {}'.format(
            self._settings.lockstep_timeout, self._simulator.time_s, '; '.join(reasons))
        if self._settings.lockstep_at_timeout == _END:
            raise UserError(line, 'see why, set lockstep_timeout higher, or leave the topic out '
                                  'of lockstep')
        rospy.logwarn('%s. Time goes on, and waits for it again when it answers', line)
        with self._lock:
            for answers in late:
                answers.is_given_up = True
            self._gate.end(Wait.ANSWERS, *late)


def _is_within(topic: str, namespace: str) -> bool:
    return topic.startswith(namespace + '/')


def _resolved(namespaces: Sequence[str]) -> Set[str]:
    return set(map(rospy.resolve_name, filter(None, namespaces)))
