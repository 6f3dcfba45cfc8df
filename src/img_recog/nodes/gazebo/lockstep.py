"""Lockstep: simulated time stands after each image until other nodes have answered it."""
import threading
import time
from functools import partial
from typing import Any, Callable, Collection, Dict, List, Mapping, Optional, Sequence, Set

import rospy

from img_recog.conversions import robot_msgs
from img_recog.errors import SimulationError, UserError
from img_recog.nodes.gazebo.answering_nodes import AnsweringNodes
from img_recog.nodes.gazebo.lockstep_settings import END, KINDS, LockstepSettings
from img_recog.nodes.gazebo.standing_report import StandingReport
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.ros.transport.settled_subscriber import SettledSubscriber

_POLL_S, _MAX_SETTLING_S = 0.0001, 1.0
_BUFFER_BYTES = 1 << 24     # an answer may be an image


class _Answers:
    """What has come on one topic.

    expected: the stamp of the message that is not answered yet, None if there is none. newest:
    the last stamp; nodes: who has published. is_given_up: whether time goes on without them, until
    the next one comes.
    """

    def __init__(self) -> None:
        self.expected: Optional[rospy.Time] = None
        self.newest: Optional[rospy.Time] = None
        self.nodes: Dict[str, None] = {}
        self.is_given_up = False


class Lockstep:
    """Waits for the answers to messages of the sensors.

    kinds: of these sensors; redelivery: is to send their messages.

    An answer is a message with a header whose stamp is not older than that of the sensor's
    message or, where the type has no header, the next message after that one was sent. The
    command topics of the robots are subscribed to by `subscribe_commands`, all others here.
    """

    def __init__(self, settings: LockstepSettings, wake: Callable[[], None]):
        """Wait for nothing yet; wake: lets the loop call `waits` again, now."""
        self.kinds = settings.kinds
        self._settings, self._wake = settings, wake
        self._answers = {topic: _Answers() for topic in settings.topics}
        self._commands: Dict[str, SettledSubscriber] = {}
        self._others: Dict[str, SettledSubscriber] = {}
        self.redelivery = Redelivery()
        self._report = StandingReport('lockstep: ')
        self._answering = AnsweringNodes(self.redelivery, self._report)
        self._namespaces: Set[str] = set()      # of all robots, also of those that were removed
        self._lock = threading.Lock()       # of what follows, and of the answers
        self._is_sent, self._sent_s = False, 0.0
        self._is_ready, self._is_settled = False, True
        self._warn_of_extra, self._warn_of_nodes = ThrottledWarning(), ThrottledWarning()
        self._warn_of_future = ThrottledWarning()

    def subscribe_commands(self, topic: str, data_class: type,
                           keep: Callable[[Any], None]) -> SettledSubscriber:
        """Subscribe to the commands of a robot, which may be answers; `keep` stores one."""
        name = rospy.resolve_name(topic)

        def receive(msg: Any, header: Mapping[str, str]) -> None:
            keep(msg)       # first: an answer lets time go on
            if name in self._answers:
                self._receive(name, msg.header.stamp if hasattr(msg, 'header') else None,
                              header.get('callerid', ''))
        if name in self._others:
            self._others.pop(name).unregister()
        self._commands[name] = SettledSubscriber(name, data_class, receive)
        return self._commands[name]

    def forget(self, namespace: str) -> None:
        """Expect no answers from the namespace of a robot that is removed."""
        place = rospy.resolve_name(namespace)
        self._commands = {topic: each for topic, each in self._commands.items()
                          if not _is_within(topic, place)}
        with self._lock:
            for topic, answers in self._answers.items():
                if _is_within(topic, place):
                    answers.expected = None

    def check(self, kinds: Collection[str]) -> None:
        """Raise SimulationError if a robot with sensors of these kinds has none to answer."""
        if not self.kinds & set(kinds):
            raise SimulationError(
                'lockstep waits for answers to {}, but the robot has no such sensor'.format(
                    self._settings.lockstep_sensors),
                'start with camera:=robot, or set lockstep_sensors to some of {}'.format(
                    ', '.join(name for name, kind in KINDS.items() if kind in kinds)))

    def subscribe(self) -> None:
        """Subscribe to the topics that are no command topics of the robots that are there."""
        for name in self._answers:
            if name not in self._commands:
                self._others[name] = SettledSubscriber(
                    name, rospy.AnyMsg, partial(self._receive_any, name), _BUFFER_BYTES)

    def _receive_any(self, topic: str, msg: rospy.AnyMsg, header: Mapping[str, str]) -> None:
        stamp = robot_msgs.stamp_in(msg._buff, header.get('type', ''),
                                    header.get('message_definition', ''))
        self._receive(topic, stamp, header.get('callerid', ''))

    def _receive(self, topic: str, stamp: Optional[rospy.Time], node: str) -> None:
        with self._lock:
            answers = self._answers[topic]
            expected, now = answers.expected, rospy.get_rostime()
            answers.newest, answers.nodes[node] = stamp, None
            if len(answers.nodes) > 1:      # some may have ended
                answers.nodes = {each: None for each in self._publishers(topic) | {node}
                                 if each in answers.nodes}
            is_answer = expected is not None and (
                self._is_sent if stamp is None else stamp >= expected)
            if is_answer:
                answers.expected = None
            was_given_up, answers.is_given_up = answers.is_given_up, False
            is_extra = self._is_ready and stamp is None and not (is_answer or was_given_up)
            is_last = is_answer and not self._missing()
        if is_last:
            self._wake()
        if was_given_up:
            rospy.loginfo('lockstep: %s answers on %s again: simulated time waits for it', node,
                          topic)
        if len(answers.nodes) > 1:
            self._warn_of_nodes(
                'lockstep: %s publish on %s: the first message of any of them counts as the '
                'answer; leave one', ', '.join(sorted(answers.nodes)), topic)
        elif is_extra:
            self._warn_of_extra(
                'lockstep: %s publishes more than one message on %s for a message of the sensors: '
                'which one counts as the answer depends on the machine; publish one, or have time '
                'wait for a topic whose messages have a header', node, topic)
        if stamp is not None and stamp > max(now, expected or now):
            self._warn_of_future(
                'lockstep: the answer of %s on %s has the stamp %.3f s, but it is %.3f s: give it '
                'the stamp of the message that it answers', node, topic, stamp.to_sec(),
                now.to_sec())

    def _missing(self) -> List[str]:
        return [topic for topic, each in self._answers.items() if each.expected is not None]

    def _publishers(self, topic: str) -> Set[str]:
        subscriber = self._commands.get(topic) or self._others.get(topic)
        return set() if subscriber is None else subscriber.publishers()

    def expect(self, time_s: float, namespaces: Collection[str],
               all_namespaces: Collection[str]) -> None:
        """Expect answers to messages that are sent next.

        time_s: their stamp; namespaces: of the robots that have measured, and of all. A topic in
        the namespace of a robot answers the sensors of this robot, any other one those of all.
        """
        self._answering.clear()
        measured = set(map(rospy.resolve_name, filter(None, namespaces)))
        self._namespaces.update(map(rospy.resolve_name, filter(None, all_namespaces)))
        with self._lock:
            self._is_sent = False
            for topic, answers in self._answers.items():
                owners = {each for each in self._namespaces if _is_within(topic, each)}
                if not answers.is_given_up and (not owners or owners & measured):
                    answers.expected = robot_msgs.stamp_of(time_s)
            self._is_settled = False

    def notify_sent(self) -> None:
        """Call just before the messages are sent: the next ones without a header are answers."""
        with self._lock:
            if not self._is_sent:
                self._is_sent, self._sent_s = True, time.monotonic()

    def waits(self, time_s: float) -> bool:
        """Return whether simulated time, which is `time_s`, must stand; for the loop.

        Raises UserError when no answer came in time and lockstep_at_timeout is end.
        """
        if not self._is_ready:
            self._is_ready = self._answering.begins(time_s, self._types(self._answers))
            if not self._is_ready:
                return True
        with self._lock:
            missing, sent_s = self._missing(), self._sent_s if self._is_sent else None
        if missing and sent_s is not None:
            if time.monotonic() < sent_s + self._settings.lockstep_timeout:
                self._answering.deliver_again(time_s, self._types(missing), sent_s)
                self._report(time_s, 'an answer on ' + ', '.join(missing), sent_s)
            else:
                self._give_up(missing, time_s)
                missing = []
        if not missing and not self._is_settled:
            self._settle()
        return bool(missing)

    def _types(self, topics: Collection[str]) -> Dict[str, str]:
        return {name: each.type for name, each in {**self._others, **self._commands}.items()
                if name in topics}

    def restart(self) -> None:
        """Let the time without an answer begin now."""
        with self._lock:
            self._sent_s = time.monotonic()

    def _settle(self) -> None:
        """Wait until all commands are taken that were sent before the answers."""
        end_s = time.monotonic() + _MAX_SETTLING_S
        while (not all(each.is_settled() for each in self._commands.values())
               and time.monotonic() < end_s):
            time.sleep(_POLL_S)
        self._is_settled = True

    def _give_up(self, topics: Sequence[str], time_s: float) -> None:
        reasons = [self._reason(topic) for topic in topics]
        line = 'lockstep: no answer in {:g} s to what was measured at {:.3f} s: {}'.format(
            self._settings.lockstep_timeout, time_s, '; '.join(reasons))
        if self._settings.lockstep_at_timeout == END:
            raise UserError(line, 'see why, set lockstep_timeout higher, or leave the topic out '
                                  'of lockstep')
        rospy.logwarn('%s. Time goes on, and waits for it again when it answers', line)
        with self._lock:
            for topic in topics:
                answers = self._answers[topic]
                answers.expected, answers.is_given_up = None, True

    def _reason(self, topic: str) -> str:
        """Return what there is on a topic in place of an answer."""
        answers = self._answers[topic]
        if not self._publishers(topic):
            known = ', '.join(answers.nodes)
            return '{} is published by nobody{}'.format(
                topic, ' any more (before: {})'.format(known) if known else '')
        if not answers.nodes:
            return '{} has had no message yet'.format(topic)
        return 'the last message on {}, of {}, {}'.format(
            topic, ', '.join(answers.nodes), 'came before' if answers.newest is None
            else 'has the stamp {:.3f} s'.format(answers.newest.to_sec()))


def _is_within(topic: str, namespace: str) -> bool:
    return topic.startswith(namespace + '/')
