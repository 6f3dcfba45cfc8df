"""Measurements for the pages: topics that are subscribed while somebody looks."""
import math
import re
import threading
import time
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Sequence, Set, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan, PointCloud
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import color_detection_msgs, plane_msgs
from img_recog.errors import shortened
from img_recog.nodes.web.news import News
from img_recog.ros.throttle import ThrottledWarning

_DIGITS = 4             # of a number, after the decimal point
_REPEAT_S = 1.0         # log lines that differ only in numbers are sent once in this time
_PLACES_PERIOD_S = 0.2
_LEVELS = {Log.DEBUG: 'debug', Log.INFO: 'info', Log.WARN: 'warn', Log.ERROR: 'error',
           Log.FATAL: 'fatal'}
_NUMBERS = re.compile('[0-9]+')
_BUFFER_BYTES = 1 << 20
_MAX_STATUSES = 300     # of diagnostics

Topic = Tuple[str, type, Callable[[Any], None]]         # resolved name, message, callback


class Topics:
    """Subscribes to topics while somebody looks. news: what they say."""

    def __init__(self) -> None:
        self.news = News()
        self._lock = threading.Lock()
        self._is_watched, self._is_changing = False, False
        self._subscribers: Dict[str, rospy.Subscriber] = {}

    def watch(self, is_watched: bool) -> None:
        """Subscribe or unsubscribe, soon and in another thread."""
        with self._lock:
            self._is_watched = is_watched
            if not self._is_changing and set(self._wanted()) != set(self._subscribers):
                self._is_changing = True
                threading.Thread(target=self._change, daemon=True).start()

    def _topics(self) -> List[Topic]:
        """Return what is subscribed while somebody looks."""
        raise NotImplementedError

    def _forget(self) -> None:
        """Forget what was measured before: it is not the beginning of what follows."""
        self.news.clear()

    def _wanted(self) -> Dict[str, Topic]:
        return {topic[0]: topic for topic in self._topics()} if self._is_watched else {}

    def _change(self) -> None:
        while True:
            with self._lock:
                wanted = self._wanted()
                if set(wanted) == set(self._subscribers) or rospy.is_shutdown():
                    self._is_changing = False
                    return
            for name in set(self._subscribers) - set(wanted):
                self._subscribers.pop(name).unregister()
            if not self._subscribers:
                self._forget()
            for name in wanted.keys() - self._subscribers.keys():
                _, data_class, callback = wanted[name]
                self._subscribers[name] = rospy.Subscriber(
                    name, data_class, callback, buff_size=_BUFFER_BYTES, tcp_nodelay=True)


class SystemTopics(Topics):
    """What all robots have in common: the simulator, the log, the nodes, and who is where."""

    def __init__(self) -> None:
        super().__init__()
        self._robots: Dict[str, str] = {}
        self._places: Dict[str, List[float]] = {}
        self._places_s = 0.0
        self._lines: Dict[Tuple[str, str], float] = {}
        self._statuses: Set[str] = set()
        self._warn = ThrottledWarning()

    def follow(self, robots: Dict[str, str]) -> None:
        """Show the places of these robots; robots: their odometry topics by their names."""
        if robots != self._robots:
            self._robots = dict(robots)
            self._show_places()
            self.watch(self._is_watched)

    def _topics(self) -> List[Topic]:
        resolve = rospy.resolve_name
        return [(resolve('gazebo/real_time_factor'), Float64, self._factor),
                (resolve('gazebo/world_outlines'), MarkerArray, self._outlines),
                ('/diagnostics', DiagnosticArray, self._diagnosed),
                ('/rosout_agg', Log, self._logged),
                *((topic, Odometry, partial(self._placed, name))
                  for name, topic in self._robots.items())]

    def _forget(self) -> None:
        super()._forget()
        self._places.clear()
        self._statuses.clear()

    def _factor(self, msg: Float64) -> None:
        self.news.set('factor', _number(msg.data))

    def _outlines(self, msg: MarkerArray) -> None:
        self.news.set('outlines', [
            [_rounded(*corner) for corner in outline.tolist()]
            for outline in plane_msgs.outlines_from_msg(msg)])

    def _placed(self, name: str, msg: Odometry) -> None:
        now_s = time.monotonic()
        try:
            self._places[name] = _rounded(*plane_msgs.pose_from_msg(msg.pose))
        except plane_msgs.PoseError as error:
            self._warn('odom of %s: %s', name, error)
            return
        if now_s - self._places_s >= _PLACES_PERIOD_S:
            self._places_s = now_s
            self._show_places()

    def _show_places(self) -> None:
        robots = self._robots
        self.news.set('robots', {name: place for name, place in list(self._places.items())
                                 if name in robots})

    def _diagnosed(self, msg: DiagnosticArray) -> None:
        for status in msg.status:
            self._statuses.add(status.name)
            if len(self._statuses) > _MAX_STATUSES:
                self._statuses.discard(status.name)
                self._warn('more than %d names on /diagnostics: the others are not shown',
                           _MAX_STATUSES)
                return
            self.news.set('node ' + status.name, {
                'time_s': _number(time.monotonic()),
                'name': shortened(status.name), 'level': _level(status.level),
                'message': shortened(status.message),
                'values': [[shortened(each.key), shortened(each.value)]
                           for each in status.values]})

    def _logged(self, msg: Log) -> None:
        key, now_s = (msg.name, _NUMBERS.sub('0', msg.msg[:200])), time.monotonic()
        if now_s - self._lines.get(key, -_REPEAT_S) < _REPEAT_S:
            return
        if len(self._lines) > 1000:
            self._lines.clear()
        self._lines[key] = now_s
        self.news.add('log', [round(msg.header.stamp.to_sec(), 3),
                              _LEVELS.get(msg.level, 'info'), shortened(msg.name),
                              shortened(msg.msg)])


class RobotTopics(Topics):
    """What one robot does and sees. frame_id: of its odometry, '' before the first message."""

    def __init__(self, resolve: Callable[[str], str]):
        """Subscribe to nothing yet; resolve: returns the full name of a topic of the robot."""
        super().__init__()
        self.frame_id = ''
        self._pose: Optional[List[Any]] = None
        self._colors: List[str] = []
        self._warn = ThrottledWarning()
        self._list: List[Topic] = [
            (resolve('cmd_vel'), Twist, self._asked), (resolve('odom'), Odometry, self._driven),
            (resolve('scan'), LaserScan, self._scanned),
            (resolve('color_detection'), PointCloud, self._detected)]

    def _topics(self) -> List[Topic]:
        return self._list

    def _forget(self) -> None:
        super()._forget()
        self._pose, self._colors = None, []

    def _asked(self, msg: Twist) -> None:
        self.news.add('asked', _rounded(time.monotonic(), msg.linear.x, msg.angular.z))

    def _driven(self, msg: Odometry) -> None:
        try:
            pose = plane_msgs.pose_from_msg(msg.pose)
        except plane_msgs.PoseError as error:
            self._warn('odom: %s', error)
            return
        self.frame_id = msg.header.frame_id
        twist = msg.twist.twist
        self.news.add('driven', _rounded(time.monotonic(), twist.linear.x, twist.angular.z))
        self._pose = _rounded(*pose)
        self.news.set('pose', self._pose)
        self.news.extend_path(*_rounded(pose.x, pose.y))

    def _scanned(self, msg: LaserScan) -> None:
        if not (math.isfinite(msg.angle_min) and math.isfinite(msg.angle_increment)):
            self._warn('scan: angle_min %g and angle_increment %g, expected finite numbers',
                       msg.angle_min, msg.angle_increment)
            return
        # with the pose of this moment: a scan stays where it was measured until the next one comes
        self.news.set('scan', {
            'pose': self._pose, 'angle_min': msg.angle_min,
            'angle_increment': msg.angle_increment,
            'ranges': [_number(each) if msg.range_min <= each <= msg.range_max else None
                       for each in msg.ranges]})

    def _detected(self, msg: PointCloud) -> None:
        try:
            found = color_detection_msgs.from_msg(msg)
        except color_detection_msgs.ColorDetectionError as error:
            self._warn('%s', error)
            return
        self.news.add('areas', [_number(time.monotonic()), *found.areas_px])
        if found.names != self._colors:
            self._colors = found.names
            self.news.set('colors', found.names)


class Measurements:
    """What a page shows: the news of a robot, and of the system, which several robots share."""

    def __init__(self, system: Topics, robot: Topics, watched: List['Measurements']):
        """watched: those of all robots that somebody looks at; shared by them."""
        self._system, self._robot, self._watched = system, robot, watched

    def watch(self, is_watched: bool) -> None:
        """Start or stop to measure."""
        if is_watched != (self in self._watched):
            (self._watched.append if is_watched else self._watched.remove)(self)
        self._robot.watch(is_watched)
        self._system.watch(bool(self._watched))

    def since(self, cursor: Optional[Sequence[int]]) -> Tuple[Tuple[int, int], Dict[str, Any]]:
        """Return the next cursor, and what is new since a cursor; None for all."""
        system, robot = cursor or (None, None)
        system, news = self._system.news.since(system)
        robot, of_robot = self._robot.news.since(robot)
        return (system, robot), {**news, **of_robot}


def _number(value: float) -> Any:
    return round(value, _DIGITS) if math.isfinite(value) else None


def _rounded(*values: float) -> List[Any]:
    return [_number(value) for value in values]


def _level(level: Any) -> int:
    """Return the level of a diagnostic status, which is a byte in Python 3."""
    return level[0] if isinstance(level, bytes) else int(level)
