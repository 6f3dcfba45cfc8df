"""Measurements for the pages: topics that are subscribed while somebody looks."""
import math
import re
import threading
import time
from typing import Any, Callable, Dict, List, Tuple

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
_LEVELS = {Log.DEBUG: 'debug', Log.INFO: 'info', Log.WARN: 'warn', Log.ERROR: 'error',
           Log.FATAL: 'fatal'}
_NUMBERS = re.compile('[0-9]+')
_BUFFER_BYTES = 1 << 20


class MeasurementTopics:
    """Subscribes to the topics of the robot and of the nodes while somebody looks."""

    def __init__(self) -> None:
        self.news = News()
        self._lock = threading.Lock()
        self._is_watched, self._is_changing = False, False
        self._subscribers: List[rospy.Subscriber] = []
        self._lines: Dict[Tuple[str, str], float] = {}
        self._colors: List[str] = []
        self._warn = ThrottledWarning()
        self._topics: List[Tuple[str, type, Callable[[Any], None]]] = [
            ('cmd_vel', Twist, self._asked), ('odom', Odometry, self._driven),
            ('scan', LaserScan, self._scanned), ('color_detection', PointCloud, self._detected),
            ('gazebo/real_time_factor', Float64, self._factor),
            ('gazebo/world_outlines', MarkerArray, self._outlines),
            ('/diagnostics', DiagnosticArray, self._diagnosed), ('/rosout_agg', Log, self._logged)]

    def watch(self, is_watched: bool) -> None:
        """Subscribe or unsubscribe, soon and in another thread."""
        with self._lock:
            self._is_watched = is_watched
            if not self._is_changing and is_watched != bool(self._subscribers):
                self._is_changing = True
                threading.Thread(target=self._change, daemon=True).start()

    def since(self, cursor: int) -> Tuple[int, Dict[str, Any]]:
        """Return the news since this cursor, see News."""
        return self.news.since(cursor)

    def _change(self) -> None:
        while True:
            with self._lock:
                if self._is_watched == bool(self._subscribers):
                    self._is_changing = False
                    return
            if self._subscribers:
                for subscriber in self._subscribers:
                    subscriber.unregister()
                self._subscribers = []
            else:
                self.news.clear()
                self._colors = []
                self._subscribers = [
                    rospy.Subscriber(name, data_class, callback, buff_size=_BUFFER_BYTES,
                                     tcp_nodelay=True)
                    for name, data_class, callback in self._topics]

    def _asked(self, msg: Twist) -> None:
        self.news.add('asked', _rounded(time.time(), msg.linear.x, msg.angular.z))

    def _driven(self, msg: Odometry) -> None:
        try:
            pose = plane_msgs.pose_from_msg(msg.pose)
        except plane_msgs.PoseError as error:
            self._warn('odom: %s', error)
            return
        twist = msg.twist.twist
        self.news.add('driven', _rounded(time.time(), twist.linear.x, twist.angular.z))
        self.news.set('pose', _rounded(*pose))
        self.news.extend_path(*_rounded(pose.x, pose.y))

    def _scanned(self, msg: LaserScan) -> None:
        self.news.set('scan', {
            'angle_min': msg.angle_min, 'angle_increment': msg.angle_increment,
            'ranges': [_number(each) if msg.range_min <= each <= msg.range_max else None
                       for each in msg.ranges]})

    def _detected(self, msg: PointCloud) -> None:
        try:
            found = color_detection_msgs.from_msg(msg)
        except color_detection_msgs.ColorDetectionError as error:
            self._warn('%s', error)
            return
        self.news.add('areas', [_number(time.time()), *found.areas_px])
        if found.names != self._colors:
            self._colors = found.names
            self.news.set('colors', found.names)

    def _factor(self, msg: Float64) -> None:
        self.news.set('factor', _number(msg.data))

    def _outlines(self, msg: MarkerArray) -> None:
        self.news.set('outlines', [
            [_rounded(*corner) for corner in outline.tolist()]
            for outline in plane_msgs.outlines_from_msg(msg)])

    def _diagnosed(self, msg: DiagnosticArray) -> None:
        for status in msg.status:
            self.news.set('node ' + status.name, {
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


def _number(value: float) -> Any:
    return round(value, _DIGITS) if math.isfinite(value) else None


def _rounded(*values: float) -> List[Any]:
    return [_number(value) for value in values]


def _level(level: Any) -> int:
    """Return the level of a diagnostic status, which is a byte in Python 3."""
    return level[0] if isinstance(level, bytes) else int(level)
