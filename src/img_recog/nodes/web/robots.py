"""The robots that the page can show."""
import re
import threading
from typing import Dict, Iterable, List, Set, Tuple

import rosgraph
import rospy

from img_recog.errors import one_line
from img_recog.nodes.web.measurements import Measurements, SystemTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.robot import Robot
from img_recog.ros.master import master
from img_recog.ros.throttle import ThrottledWarning
from img_recog.teleoperation.settings import VelocityLimits

_COMMANDS, _ODOMETRY = 'cmd_vel', 'odom'
_PARTS = re.compile('([0-9]+)')

TopicUsers = Iterable[Tuple[str, List[str]]]


class Robots:
    """Finds the robots by their cmd_vel, and makes the parts of those that somebody looks at."""

    def __init__(self, limits: VelocityLimits, pictures: PictureTopics):
        """Make nothing yet; limits: the highest speeds."""
        self._limits, self._pictures = limits, pictures
        self._system = SystemTopics()
        self._watched: List[Measurements] = []
        self._lock = threading.Lock()
        self._made: Dict[str, Robot] = {}
        self._warn = ThrottledWarning()
        self.names: List[str] = ['']

    def update(self) -> None:
        """Look for the robots; names: those that were found, '' for one without a namespace."""
        try:
            published, subscribed, _ = master.system_state()
        except master.MasterError as error:
            self._warn('the robots: %s', one_line(error))
            return
        self.names = names_in(published, subscribed, rospy.get_namespace(),
                              rospy.get_name()) or self.names       # a new master knows none yet
        others = self.names if len(self.names) > 1 else []
        self._system.follow({name: rospy.resolve_name(name + '/odom') for name in others if name})

    def get(self, name: str) -> Robot:
        """Return the robot of this name, or the first one if there is none."""
        names = self.names
        name = name if name in names else names[0]
        with self._lock:
            if name not in self._made:
                self._made[name] = Robot(name, self._limits, self._pictures, self._system,
                                         self._watched)
            return self._made[name]


def names_in(published: TopicUsers, subscribed: TopicUsers, namespace: str,
             node: str) -> List[str]:
    """Return the names of the robots in a namespace that ends with a slash.

    A robot subscribes to its cmd_vel and publishes its odom. If none does both, those with a
    subscriber of cmd_vel, which may also be a tool; else those with a publisher. `node` itself
    does not count.
    """
    def using(topic: str, users: TopicUsers) -> Set[str]:
        return {name[len(namespace):-len(topic)].rstrip('/') for name, nodes in users
                if name.startswith(namespace) and name.endswith('/' + topic)
                and set(nodes) != {node}}
    driven = using(_COMMANDS, subscribed)
    for found in (driven & using(_ODOMETRY, published), driven, using(_COMMANDS, published)):
        legal = [name for name in found if not name or rosgraph.names.is_legal_name(name)]
        if legal:
            return sorted(legal, key=_natural)
    return []


def _natural(name: str) -> List[Tuple[int, str]]:
    """Sort tb3_2 before tb3_10."""
    return [(int(part), '') if part.isdigit() else (0, part) for part in _PARTS.split(name)]
