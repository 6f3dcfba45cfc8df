"""The robots that pages show and drive."""
import math
import re
import threading
import time
from dataclasses import dataclass
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Set, Tuple, Union

import rosgraph
import rospy
from std_srvs.srv import Trigger

from img_recog.camera_arguments import CAMERA_TOPIC
from img_recog.conversions import twist_msgs
from img_recog.errors import UserError, one_line
from img_recog.nodes.web.color_samples import ColorSamples
from img_recog.nodes.web.measurements import RobotMeasurements, SystemTopics
from img_recog.nodes.web.navigation_topics import NavigationTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.simulation_service import PosePublisher
from img_recog.nodes.web.tuning import ColorTuning
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC
from img_recog.recognition.recognition_settings import DEFAULT_COLORS, color_names
from img_recog.ros import master_calls, parameters, timed_xmlrpc
from img_recog.ros.stopping_publisher import StoppingPublisher
from img_recog.ros.throttle import ThrottledWarning
from img_recog.settings import Settings, between, not_empty, setting
from img_recog.teleoperation import VelocityLimits

_PERIOD_S = 0.05
POLL_PERIOD_S = 1.0    # how often the threads check for the shutdown
HOLD_S = 0.3            # a page repeats its command; after this time without one, the robot stops
YIELD_PERIOD_S = 0.2
READ_PERIOD_S = 1.0    # of the nodes that can yield
_SERVICE = '/yield'
_STOPS = 3              # zeros that are sent after a release
_COMMANDS, _ODOMETRY = 'cmd_vel', 'odom'

TopicUsers = Mapping[str, List[str]]


@dataclass(frozen=True)
class WebSettings(Settings):
    """Where the page is served.

    web_host: the address to listen on; the default is this computer alone. Anyone who reaches it
    and has the token drives the robot; nothing is encrypted.
    web_port: the first port to try; if it is taken, the next free one of the ten after it.
    """

    web_host: str = setting('127.0.0.1', not_empty())
    web_port: int = setting(8080, between(1, 65535))


class Speeds:
    """Who drives, how fast, and until when. Independent of ROS; for any thread."""

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now, self._lock = now, threading.Lock()
        self._owner: Optional[object] = None        # the last one that has not released
        self._refused: Set[object] = set()
        self._shares, self._until_s = (0.0, 0.0), 0.0

    def hold(self, owner: object, linear: float, angular: float) -> bool:
        """Set the shares of the highest speeds for HOLD_S; return False if that is refused.

        While another owner drives, all but a stop is refused; a stop takes over from it. Who was
        refused or lost the robot is refused until it has released: the robot must not obey it when
        the other one pauses, long after its key was pressed.
        """
        with self._lock:
            has_other = self._owner not in (None, owner)
            if (linear or angular) and (
                    owner in self._refused or has_other and self._is_driven()):
                self._refused.add(owner)
                return False
            if has_other:
                self._refused.add(self._owner)
            self._owner, self._shares = owner, (linear, angular)
            self._until_s = self._now() + HOLD_S
            return True

    def release(self, owner: object) -> None:
        """End what this owner holds."""
        with self._lock:
            self._refused.discard(owner)
            if self._owner is owner:
                self._owner = None

    def current(self) -> Optional[Tuple[float, float]]:
        """Return the shares, None if nobody drives."""
        with self._lock:
            return self._shares if self._is_driven() else None

    def _is_driven(self) -> bool:
        return self._owner is not None and self._now() < self._until_s


class Driving:
    """Publishes cmd_vel (geometry_msgs/Twist, 20 Hz) while somebody drives, and zeros at the end.

    Calls the service NODE/yield (std_srvs/Trigger) of each other publisher of cmd_vel that has it,
    so that this node publishes nothing meanwhile. settings: the highest speeds that are allowed;
    limits: those that are set.
    """

    def __init__(self, settings: VelocityLimits, topic: str):
        """Advertise `topic`, the full name of the robot's cmd_vel."""
        self.settings = settings
        self.limits = {name: getattr(settings, name)
                       for name in ('max_linear_velocity', 'max_angular_velocity')}
        self._speeds, self._driven = Speeds(), threading.Event()
        self._warn = ThrottledWarning()
        self._asked: Set[str] = set()       # services whose answer has not come yet
        # driven until the zeros of a release were sent, too
        self._topic, self._velocity = topic, StoppingPublisher(topic, self._driven.is_set)
        for target in (self._publish, self._hold_others):
            threading.Thread(target=target, daemon=True).start()

    def limit(self, name: str, value: float) -> None:
        """Set a highest speed: max_linear_velocity in m/s or max_angular_velocity in rad/s.

        At most that of the parameter.
        """
        if math.isfinite(value):
            self.limits[name] = max(0.0, min(getattr(self.settings, name), value))

    def hold(self, owner: object, linear: float, angular: float) -> bool:
        """Drive with these shares of the highest speeds, -1 to 1, until HOLD_S have passed.

        Return False if another owner drives, or drove when this one began.
        """
        is_held = self._speeds.hold(owner, linear, angular)
        if is_held:
            self._driven.set()
        return is_held

    def release(self, owner: object) -> None:
        """Stop the robot, if this owner drives it."""
        self._speeds.release(owner)

    def _publish(self) -> None:
        while not rospy.is_shutdown():
            if not self._driven.wait(POLL_PERIOD_S):
                continue
            shares = self._speeds.current()
            while shares is not None and not rospy.is_shutdown():
                self._velocity.publish(twist_msgs.to_msg(
                    shares[0] * self.limits['max_linear_velocity'],
                    shares[1] * self.limits['max_angular_velocity']))
                time.sleep(_PERIOD_S)
                shares = self._speeds.current()
            for _ in range(_STOPS):
                self._velocity.publish(twist_msgs.to_msg(0.0))
            self._driven.clear()
            if self._speeds.current() is not None:      # held again meanwhile
                self._driven.set()

    def _hold_others(self) -> None:
        """Let the other nodes yield as long as somebody drives."""
        services: List[str] = []
        read_s = -math.inf
        while not rospy.is_shutdown():
            if not self._driven.is_set():
                read_s = -math.inf
                self._driven.wait(POLL_PERIOD_S)
                continue
            try:
                if time.monotonic() - read_s > READ_PERIOD_S:      # others may start meanwhile
                    services, read_s = yield_services(self._topic), time.monotonic()
            except timed_xmlrpc.ERRORS as error:
                self._warn('another node may drive the robot too: no master answers: %s',
                           one_line(error))
            # each in a thread: one that does not answer must not keep the others from yielding
            for name in set(services) - self._asked:
                self._asked.add(name)
                threading.Thread(target=self._ask, args=(name,), daemon=True).start()
            time.sleep(YIELD_PERIOD_S)

    def _ask(self, service: str) -> None:
        """Ask a node to yield."""
        try:
            answer = rospy.ServiceProxy(service, Trigger)()
            if not answer.success:
                self._warn('%s: %s', service, answer.message)
        except Exception as error:      # rospy raises more than it documents
            self._warn('another node may drive the robot too: %s', one_line(error))
        finally:
            self._asked.discard(service)


def yield_services(topic: str) -> List[str]:
    """Return the services by which the publishers of a topic can be asked to yield."""
    state = master_calls.calls().state()
    return sorted(node + _SERVICE for node in state.published.get(topic, ())
                  if node + _SERVICE in state.services)


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
            state = master_calls.calls().state()
            if self._made:
                types = dict(master_calls.calls().call('getTopicTypes'))
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
