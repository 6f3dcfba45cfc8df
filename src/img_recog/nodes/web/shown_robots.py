"""The robots that pages show and drive."""
import re
import threading
from typing import Dict, List, Mapping, NamedTuple, Set, Union

import rosgraph
import rospy

from img_recog.camera_arguments import CAMERA_TOPIC
from img_recog.errors import UserError, one_line
from img_recog.nodes.web.color_samples import ColorSamples
from img_recog.nodes.web.driving import Driving
from img_recog.nodes.web.measurements import RobotMeasurements, SystemTopics
from img_recog.nodes.web.navigation_topics import NavigationTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.simulation_service import PosePublisher
from img_recog.nodes.web.tuning import ColorTuning
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC
from img_recog.recognition.recognition_settings import DEFAULT_COLORS, color_names
from img_recog.ros import parameters, timed_xmlrpc
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.ros.master import master
from img_recog.teleoperation.profile import VelocityLimits

_COMMANDS, _ODOMETRY = 'cmd_vel', 'odom'

TopicUsers = Mapping[str, List[str]]


def resolve(robot: str, name: str) -> str:
    """Return the full name of a topic or node of a robot."""
    is_relative = robot and not name.startswith('/')
    return rospy.resolve_name('{}/{}'.format(robot, name) if is_relative else name)


class PictureTopic(NamedTuple):
    """A topic with images; title: the key of its title, which may have a color in it."""

    topic: str
    title: str
    color: str = ''


class ShownRobot:
    """A robot that pages show and drive.

    name: its namespace, below that of the node; '' for the only robot. topics: what is measured,
    of the system and of the robot. navigation: the last of them.
    """

    def __init__(self, name: str, limits: VelocityLimits, pictures: PictureTopics,
                 system: SystemTopics):
        """Advertise its topics; pictures and system: those of all robots."""
        self.name = name
        self._warn = ThrottledWarning()
        own = RobotMeasurements(self.resolve)
        self.navigation = NavigationTopics(self.resolve, lambda: own.frame_id)
        self.topics = system, own, self.navigation
        self.driving = Driving(limits, self.resolve('cmd_vel'))
        self.colors = ColorTuning(self.resolve('color_extract'))
        self.samples = ColorSamples(self.resolve(CAMERA_TOPIC), pictures)
        self.pose = PosePublisher(self.name, lambda: own.frame_id)

    def resolve(self, name: str) -> str:
        """Return the full name of a topic or node of this robot."""
        return resolve(self.name, name)

    def picture_topics(self) -> List[PictureTopic]:
        """Return the pictures that there can be, those of the colors last. Waits for the master.

        page.css makes those after the third smaller if they are many.
        """
        names, topics = list(DEFAULT_COLORS), {}
        try:
            given = parameters.value(self.resolve('color_extract')) or {}
            names = list(color_names(given.get(COLORS, names)))
            topics = {name: given.get(IMAGE_TOPIC.format(name)) for name in names}
        except (*timed_xmlrpc.ERRORS, UserError, AttributeError) as error:
            self._warn('the colors of color_extract: %s', one_line(error))
        return [
            PictureTopic(self.resolve(CAMERA_TOPIC), 'camera'),
            PictureTopic(rospy.resolve_name('gazebo/view/image_raw'), 'view'),
            PictureTopic(self.resolve('camera/rgb/image_raw'), 'robot_camera'),
            *(PictureTopic(self.resolve(topics.get(name) or name + '_image'), 'mask', name)
              for name in names)]


class ShownRobots:
    """Finds the robots by their cmd_vel, and makes the parts of those that somebody looks at.

    names: at least one; '' for a robot without a namespace. seen: topics that were published.
    """

    def __init__(self, limits: VelocityLimits, pictures: PictureTopics, system: SystemTopics):
        """Make nothing yet; limits: the highest speeds; system: what all robots share."""
        self._limits, self._pictures, self._system = limits, pictures, system
        self._lock = threading.Lock()
        self._made: Dict[str, ShownRobot] = {}
        self._types: Dict[str, str] = {}
        self.seen: Set[str] = set()
        self._warn = ThrottledWarning()
        self.names: List[str] = ['']

    def update(self) -> None:
        """Look for the robots. Waits for the master: not for the event loop."""
        try:
            state = master.calls().state()
            if self._made:
                types = dict(master.calls().call('getTopicTypes'))
                self._types = {name: types[name] for name in state.published if name in types}
                self.seen |= set(self._types)
        except timed_xmlrpc.ERRORS as error:
            self._warn('the robots: no master answers: %s', one_line(error))
            return
        self.names = names_in(state.published, state.subscribed, rospy.get_namespace(),
                              rospy.get_name()) or self.names       # a new master knows none yet
        others = self.names if len(self.names) > 1 else []
        for robot in list(self._made.values()):
            robot.navigation.follow(self._types)
        self._system.follow({name: rospy.resolve_name(name + '/odom') for name in others if name})

    def get(self, name: str) -> ShownRobot:
        """Return the robot of this name, or the first one if there is none.

        Waits for the master if it is not known: not for the event loop.
        """
        if name not in self.names:
            self.update()
        names = self.names
        name = name if name in names else names[0]
        with self._lock:
            if name not in self._made:
                self._made[name] = ShownRobot(name, self._limits, self._pictures, self._system)
                self.update()
            return self._made[name]


def names_in(published: TopicUsers, subscribed: TopicUsers, namespace: str,
             node: str) -> List[str]:
    """Return the names of the robots in a namespace that ends with a slash.

    A robot subscribes to its cmd_vel and publishes its odom. If none does both, those with a
    subscriber of cmd_vel, which may also be a tool; else those with a publisher. `node` itself
    does not count.
    """
    def using(topic: str, users: TopicUsers) -> Set[str]:
        return {name[len(namespace):-len(topic)].rstrip('/') for name, nodes in users.items()
                if name.startswith(namespace) and name.endswith('/' + topic)
                and set(nodes) != {node}}
    driven = using(_COMMANDS, subscribed)
    for found in (driven & using(_ODOMETRY, published), driven, using(_COMMANDS, published)):
        legal = [name for name in found if not name or rosgraph.names.is_legal_name(name)]
        if legal:
            return sorted(legal, key=_natural)
    return []


def _natural(name: str) -> List[Union[str, int]]:
    """Sort tb3_2 before tb3_10."""
    return [int(part) if part.isdigit() else part for part in re.split('([0-9]+)', name)]
