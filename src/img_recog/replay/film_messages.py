"""Chooses and reads the messages of a bag that a film shows."""
import itertools
import logging
from typing import Any, Dict, Iterator, List, Sequence, Set, Tuple

import numpy as np
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import plane_msgs
from img_recog.errors import shortened
from img_recog.replay.bags import DAMAGE_ERRORS, BagFrames, damaged

_KINDS = {'odom': Odometry, 'scan': LaserScan, 'cmd_vel': Twist, 'outlines': MarkerArray}
# the ends of their usual names; of outlines, only these are of the world
_USUAL = {'odom': 'odom', 'scan': 'scan', 'cmd_vel': 'cmd_vel', 'outlines': 'world_outlines'}
_log = logging.getLogger('film.py')


class Messages:
    """The messages of a bag that a film shows.

    path: of the bag; images: number of images so far.
    """

    def __init__(self, path: str, frames: BagFrames):
        self.path, self._bag = path, frames.bag
        self.images = 0
        # role and message type of each topic that is shown
        self._shown: Dict[str, Tuple[str, Any]] = {frames.topic: ('image', frames.message_type)}
        connections = self._connections()
        others: List[str] = []
        for role, kind in _KINDS.items():
            found = sorted({name for name, type_name, _ in connections if type_name == kind._type})
            usual = [name for name in found if name.endswith(_USUAL[role])]
            names = usual or (found if role != 'outlines' else [])
            readable = [name for name in names if (name, kind._type, kind._md5sum) in connections]
            others += ['{} ({})'.format(name, kind._type) for name in names
                       if name not in readable]
            if readable:
                self._shown[nearest(readable, frames.topic)] = role, kind
        if others:
            _log.warning('the film does not show %s: the message type has another definition in '
                         'this ROS', shortened(', '.join(others)))

    def _connections(self) -> Set[Tuple[str, str, str]]:
        """Return topic, type and MD5 sum of all connections; a topic may have several types."""
        found: Set[Tuple[str, str, str]] = set()

        def take_none(topic: str, type_name: str, md5sum: str, *_: Any) -> bool:
            found.add((topic, type_name, md5sum))
            return False
        for _ in self._bag.read_messages(connection_filter=take_none):
            pass
        return found

    def _is_readable(self, topic: str, type_name: str, md5sum: str, *_: Any) -> bool:
        kind = self._shown[topic][1]
        return (type_name, md5sum) == (kind._type, kind._md5sum)

    def outlines(self) -> List[np.ndarray]:
        """Return the outlines of what stands in the world; none if they were not recorded."""
        for role, msg, _ in self._read(['outlines']):
            return plane_msgs.outlines_from_msg(msg)
        return []

    def in_order(self) -> Iterator[Tuple[str, Any, float]]:
        """Yield role, message and time of recording in s, without the outlines."""
        return self._read(['image', 'odom', 'scan', 'cmd_vel'])

    def _read(self, roles: Sequence[str]) -> Iterator[Tuple[str, Any, float]]:
        topics = [name for name, (role, _) in self._shown.items() if role in roles]
        if not topics:
            return
        try:
            for name, msg, time in self._bag.read_messages(
                    topics, connection_filter=self._is_readable):
                yield self._shown[name][0], msg, time.to_sec()
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
