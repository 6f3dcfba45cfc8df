"""Chooses and reads the messages of a bag that a film or a plot shows."""
import itertools
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np

from img_recog.conversions import plane_msgs
from img_recog.errors import shortened
from img_recog.recordings.bag_file import DAMAGE_ERRORS, BagFile, damaged

# the ends of their usual names; of outlines and detections, only these are of the world and of
# the colors
_USUAL = {'odom': 'odom', 'scan': 'scan', 'cmd_vel': 'cmd_vel', 'outlines': 'world_outlines',
          'detections': 'color_detection'}
_ONLY_USUAL = 'outlines', 'detections'


class RecordedMessage(NamedTuple):
    """A message, the time of its recording in s, and the name of the node that has sent it."""

    role: str
    msg: Any
    time_s: float
    sender: str


class Messages:
    """The messages of a bag that are shown.

    others: topics that cannot be shown, as a text, '' if there are none.
    """

    def __init__(self, path: str, bag: BagFile, near: str, kinds: Mapping[str, Any],
                 given: Mapping[str, Tuple[str, Any]]):
        """Choose topics of an open bag.

        near: of several topics, those of the same robot as this one are chosen. kinds: the message
        type of each role to choose a topic for. given: role and message type of other topics.
        """
        self.path, self._bag = path, bag
        self._shown: Dict[str, Tuple[str, Any]] = dict(given)
        connections = bag.connections()
        others: List[str] = []
        for role, kind in kinds.items():
            found = sorted({name for name, type_name, _ in connections if type_name == kind._type})
            usual = [name for name in found if name.endswith(_USUAL[role])]
            names = usual or (found if role not in _ONLY_USUAL else [])
            readable = [name for name in names if (name, kind._type, kind._md5sum) in connections]
            others += ['{} ({})'.format(name, kind._type) for name in names
                       if name not in readable]
            if readable:
                self._shown[nearest(readable, near)] = role, kind
        self.others = '{}: the message type has another definition in this ROS'.format(
            shortened(', '.join(others))) if others else ''

    def outlines(self) -> List[np.ndarray]:
        """Return the outlines of what stands in the world; none if they were not recorded."""
        for recorded in self._read(['outlines']):
            return plane_msgs.outlines_from_msg(recorded.msg)
        return []

    def in_order(self) -> Iterator[RecordedMessage]:
        """Yield all messages in the order of their recording, without the outlines."""
        return self._read([role for role, _ in self._shown.values() if role != 'outlines'])

    def _read(self, roles: Sequence[str]) -> Iterator[RecordedMessage]:
        kinds = {name: kind for name, (role, kind) in self._shown.items() if role in roles}
        if not kinds:
            return
        try:
            for name, msg, time, connection in self._bag.messages(kinds):
                yield RecordedMessage(self._shown[name][0], msg, time.to_sec(),
                                      connection.get('callerid', b'').decode(errors='replace'))
        except DAMAGE_ERRORS as error:
            raise damaged(self.path, error)


def nearest(names: Sequence[str], topic: str) -> str:
    """Return the name that shares most namespaces with a topic: it is of the same robot.

    >>> nearest(['/tb3_0/odom', '/tb3_1/odom'], '/tb3_1/usb_cam/image_raw')
    '/tb3_1/odom'
    """
    parts = topic.split('/')

    def shared(name: str) -> int:
        pairs = zip(name.split('/'), parts)
        return sum(1 for _ in itertools.takewhile(lambda pair: pair[0] == pair[1], pairs))
    return max(names, key=shared)
