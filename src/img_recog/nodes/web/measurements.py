"""Measurements for the pages: topics that are subscribed while somebody looks."""
import contextlib
import math
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, PointCloud
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import color_detection_msgs, plane_msgs
from img_recog.errors import one_line
from img_recog.nodes.web.updates import Updates
from img_recog.ros.throttle import ThrottledWarning

_DIGITS = 4             # of a number, after the decimal point
PLACES_PERIOD_S = 0.2
RETRY_PERIOD_S = 1.0
_BUFFER_BYTES = 1 << 20
_MAX_PATH = 4000        # points
_PATH_STEP_M = 0.02
_JUMP_M = 0.5           # between two positions that follow one another: the robot was moved

Topic = Tuple[str, type, Callable[[Any], None]]         # resolved name, message, callback
Source = Callable[[Updates], Iterable[Topic]]           # topics, and where their callbacks write


class WatchedTopics:
    """Subscribes to topics while somebody looks. updates: what they say."""

    def __init__(self) -> None:
        self.updates = Updates()
        self._topics: List[Topic] = []
        self._lock = threading.Lock()
        self._is_watched, self._is_changing = False, False
        self._subscribers: Dict[str, rospy.Subscriber] = {}
        self._warn = ThrottledWarning()

    def watch(self, is_watched: bool) -> None:
        """Subscribe or unsubscribe, soon and in another thread."""
        with self._lock:
            self._is_watched = is_watched
            if not self._is_changing and set(self._wanted()) != set(self._subscribers):
                self._is_changing = True
                threading.Thread(target=self._change, name='subscriptions', daemon=True).start()

    def topics(self) -> List[Topic]:
        """Return what is subscribed while somebody looks."""
        return self._topics

    def _forget(self) -> None:
        """Forget what was measured before: it is no start of what follows."""
        self.updates.clear()

    def _wanted(self) -> Dict[str, Topic]:
        return {topic[0]: topic for topic in self.topics()} if self._is_watched else {}

    def _change(self) -> None:
        while True:
            with self._lock:
                wanted = self._wanted()
                if set(wanted) == set(self._subscribers) or rospy.is_shutdown():
                    self._is_changing = False
                    return
            for name in set(self._subscribers) - set(wanted):
                with self._continued(name):
                    self._subscribers.pop(name).unregister()
            if not self._subscribers:
                self._forget()
            for name in wanted.keys() - self._subscribers.keys():
                _, data_class, callback = wanted[name]
                with self._continued(name):
                    self._subscribers[name] = rospy.Subscriber(
                        name, data_class, callback, buff_size=_BUFFER_BYTES, tcp_nodelay=True)

    @contextlib.contextmanager
    def _continued(self, name: str) -> Iterator[None]:
        """Warn of an error in the block, and pause: one topic must not end all others."""
        try:
            yield
        except Exception as error:      # rospy raises more than it documents
            self._warn('%s: %s: %s', name, type(error).__name__, one_line(error))
            time.sleep(RETRY_PERIOD_S)


class SystemTopics(WatchedTopics):
    """What all robots have in common: the simulator, who is where, and the sources of the tabs."""

    def __init__(self, sources: Iterable[Source]) -> None:
        super().__init__()
        self._robots: Dict[str, str] = {}
        self._places: Dict[str, List[float]] = {}
        self._places_s = 0.0
        resolve = rospy.resolve_name
        self._topics = [
            (resolve('gazebo/real_time_factor'), Float64, self._factor),
            (resolve('gazebo/world_outlines'), MarkerArray, self._outlines),
            *(topic for source in sources for topic in source(self.updates))]

    def follow(self, robots: Dict[str, str]) -> None:
        """Show the places of these robots; robots: their odometry topics by their names."""
        if robots != self._robots:
            self._robots = dict(robots)
            self._show_places()
            self.watch(self._is_watched)

    def topics(self) -> List[Topic]:
        """Return what is subscribed while somebody looks."""
        return [*self._topics, *((topic, Odometry, partial(self._placed, name))
                                 for name, topic in self._robots.items())]

    def _forget(self) -> None:
        super()._forget()
        self._places.clear()

    def _factor(self, msg: Float64) -> None:
        self.updates.set('factor', number(msg.data))

    def _outlines(self, msg: MarkerArray) -> None:
        self.updates.set('outlines', [
            [rounded(*corner) for corner in outline.tolist()]
            for outline in plane_msgs.outlines_from_msg(msg)])

    def _placed(self, name: str, msg: Odometry) -> None:
        now_s = time.monotonic()
        try:
            self._places[name] = rounded(*plane_msgs.pose_from_msg(msg.pose))
        except plane_msgs.PoseError as error:
            self._warn('odom of %s: %s', name, error)
            return
        if now_s - self._places_s >= PLACES_PERIOD_S:
            self._places_s = now_s
            self._show_places()

    def _show_places(self) -> None:
        robots = self._robots
        self.updates.set('robots', {name: place for name, place in list(self._places.items())
                                    if name in robots})


class RobotMeasurements(WatchedTopics):
    """What one robot does and sees. frame_id: of its odometry, '' before the first message."""

    def __init__(self, resolve: Callable[[str], str]):
        """Subscribe to nothing yet; resolve: returns the full name of a topic of the robot."""
        super().__init__()
        self.frame_id = ''
        self._pose: Optional[List[Any]] = None
        self._path_end: Optional[Tuple[float, float]] = None
        self._colors: List[str] = []
        self._topics = [
            (resolve('cmd_vel'), Twist, self._asked), (resolve('odom'), Odometry, self._driven),
            (resolve('scan'), LaserScan, self._scanned),
            (resolve('color_detection'), PointCloud, self._detected)]

    def _forget(self) -> None:
        super()._forget()
        self._pose, self._path_end, self._colors = None, None, []

    def _asked(self, msg: Twist) -> None:
        self.updates.add('asked', rounded(time.monotonic(), msg.linear.x, msg.angular.z))

    def _driven(self, msg: Odometry) -> None:
        try:
            pose = plane_msgs.pose_from_msg(msg.pose)
        except plane_msgs.PoseError as error:
            self._warn('odom: %s', error)
            return
        self.frame_id = msg.header.frame_id
        twist = msg.twist.twist
        self.updates.add('driven', rounded(time.monotonic(), twist.linear.x, twist.angular.z))
        self._extend_path(pose)
        self._pose = rounded(*pose)
        self.updates.set('pose', self._pose)

    def _extend_path(self, pose: plane_msgs.PlanePose) -> None:
        """Add a position to the path if it is far enough from the last one of the path.

        None is added before a position to which the robot was moved.
        """
        x, y = rounded(pose.x, pose.y)
        if self._pose is not None and math.dist((x, y), self._pose[:2]) > _JUMP_M:
            self.updates.add('path', None, _MAX_PATH)
        elif self._path_end is not None and (
                abs(x - self._path_end[0]) + abs(y - self._path_end[1]) < _PATH_STEP_M):
            return
        self._path_end = x, y
        self.updates.add('path', (x, y), _MAX_PATH)

    def _scanned(self, msg: LaserScan) -> None:
        if not (math.isfinite(msg.angle_min) and math.isfinite(msg.angle_increment)):
            self._warn('scan: angle_min %g and angle_increment %g, expected finite numbers',
                       msg.angle_min, msg.angle_increment)
            return
        # with the pose of this moment: a scan stays where it was measured until the next one comes
        self.updates.set('scan', {
            'pose': self._pose, 'angle_min': msg.angle_min,
            'angle_increment': msg.angle_increment,
            'ranges': [number(each) if msg.range_min <= each <= msg.range_max else None
                       for each in msg.ranges]})

    def _detected(self, msg: PointCloud) -> None:
        try:
            found = color_detection_msgs.from_msg(msg)
        except color_detection_msgs.ColorDetectionError as error:
            self._warn('%s', error)
            return
        self.updates.add('areas', [number(time.monotonic()), *found.areas_px])
        if found.names != self._colors:
            self._colors = found.names
            self.updates.set('colors', found.names)


def number(value: float) -> Optional[float]:
    """Return a number as the page gets it, None if it is not finite."""
    return round(value, _DIGITS) if math.isfinite(value) else None


def rounded(*values: float) -> List[Any]:
    """Return numbers as the page gets them."""
    return [number(value) for value in values]
