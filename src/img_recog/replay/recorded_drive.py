"""A drive that was recorded in a bag, as the data of its picture."""
import contextlib
import itertools
import math
from typing import Dict, Iterable, List, Mapping, Sequence, Tuple, Union

import numpy as np
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import color_detection_msgs, plane_msgs, twist_msgs
from img_recog.conversions.plane_msgs import MAX_NUMBER
from img_recog.errors import UserError, shortened
from img_recog.recognition.recognition_settings import Color
from img_recog.recordings.bag_file import BagFile
from img_recog.replay.bag_messages import Messages
from img_recog.replay.plot_data import PlotColor, PlotData, X, Y

_ODOM = 'odom'
_OTHERS = {'cmd_vel': Twist, 'detections': PointCloud, 'outlines': MarkerArray}
_JUMP_M = 0.5           # between two positions that follow one another: the robot was moved
_HUE_STEP = 50          # between colors of which only the names are known


def drive_of(path: str, bag: BagFile, odometry: str, known: Sequence[Color]
             ) -> Tuple[PlotData, str]:
    """Return what a robot of an open bag has done, and what of it is not shown, '' for nothing.

    path: of the bag in messages. odometry: the topic of the robot. known: colors, for those that
    were recognized. Raises UserError if there is no odometry, or the bag is damaged.
    """
    messages = Messages(path, bag, odometry, _OTHERS, {odometry: (_ODOM, Odometry)})
    moved: List[tuple] = []
    found: List[Dict[str, float]] = []
    sent: Dict[str, List[tuple]] = {}           # by the name of the sender
    start_s, now_s = None, 0.0
    for role, msg, time_s, sender in messages.in_order():
        start_s = time_s if start_s is None else start_s
        now_s = time_s - start_s
        with contextlib.suppress(UserError):    # a picture needs no warning for each message
            if role == _ODOM:
                pose = plane_msgs.pose_from_msg(msg.pose)
                moved.append((now_s, *pose, *_velocity(msg.twist.twist)))
            elif role == 'cmd_vel':
                sent.setdefault(sender, []).append((now_s, *_velocity(msg)))
            else:
                detected = color_detection_msgs.from_msg(msg)
                found.append({'': now_s, **dict(zip(detected.names, detected.areas_px))})
    if not moved:
        raise UserError('{} has no usable message on {}'.format(path, odometry),
                        'record it while the robot runs')
    motion = np.array(moved)
    steps = np.hypot(*np.diff(motion[:, [X, Y]], axis=0).T)
    names = list(dict.fromkeys(name for row in found for name in row if name))
    areas = [[row.get(name, math.nan) for name in ('', *names)] for row in found]
    driving = [each for each in sent.values() if any(any(row[1:]) for row in each)]
    idle = [each for each in sent.values() if each not in driving]
    return PlotData(
        colors_of(names, known), motion, np.reshape(areas, (-1, 1 + len(names))),
        _in_order(driving), _in_order(idle), now_s, messages.outlines(),
        (np.flatnonzero(steps > _JUMP_M) + 1).tolist()), messages.others


def _velocity(twist: Twist) -> Tuple[float, float]:
    """Return a velocity; raise UserError if it cannot be drawn."""
    linear, angular, _ = twist_msgs.from_msg(twist)
    if max(abs(linear), abs(angular)) > MAX_NUMBER:
        raise UserError('got {:g} m/s, {:g} rad/s, expected numbers up to {:g}'.format(
            linear, angular, MAX_NUMBER))
    return linear, angular


def _in_order(sent: Iterable[List[tuple]]) -> np.ndarray:
    """Return the commands (n, 3) of several senders."""
    return np.reshape(sorted(itertools.chain(*sent)), (-1, 3))


def colors_of(names: Sequence[str], known: Sequence[Color]) -> List[Union[Color, PlotColor]]:
    """Return the colors of these names.

    >>> colors_of(['green', 'white'], [])
    [PlotColor(name='green', hue=(0, 0), area_limit_px=None), \
PlotColor(name='white', hue=(50, 50), area_limit_px=None)]
    """
    colors: Dict[str, Union[Color, PlotColor]] = {color.name: color for color in known}
    return [colors[name] if name in colors else PlotColor(name, (number * _HUE_STEP % 180,) * 2)
            for number, name in enumerate(names)]


def odometry_of(types: Mapping[str, str], robot: str, place: str) -> str:
    """Return the topic of the odometry of a robot.

    types: the message types of all topics. robot: its namespace; if empty, the robot without one,
    or the only one. Raises UserError if there is no such robot; place: where it was looked for.

    >>> odometry_of({'/tb3_0/odom': 'nav_msgs/Odometry', '/odom': 'std_msgs/String'}, '', 'it')
    '/tb3_0/odom'
    """
    found = sorted(name for name, type_name in types.items() if type_name == Odometry._type)
    wanted = '/'.join(filter(None, (robot.strip('/'), _ODOM)))
    exact = [name for name in found if name.lstrip('/') == wanted]
    if exact or len(found) == 1 and not robot:
        return (exact or found)[0]
    raise UserError('{} has no odometry on /{}; there is {}'.format(
        place, wanted, shortened(', '.join(found) or 'none of type nav_msgs/Odometry')),
        'choose a robot with --robot, as tb3_0 for /tb3_0/odom' if found
        else 'record it while the robot runs')


def topics_beside(odometry: str, topics: Iterable[str]) -> List[str]:
    """Return the topics to record of a robot and of its world; topics: all that there are.

    >>> topics_beside('/lab/tb3_0/odom', ['/lab/gazebo/world_outlines'])
    ['/lab/tb3_0/odom', '/lab/tb3_0/cmd_vel', '/lab/tb3_0/color_detection', \
'/lab/gazebo/world_outlines']
    """
    namespace = odometry.rpartition('/')[0]
    return [odometry, namespace + '/cmd_vel', namespace + '/color_detection',
            *(name for name in topics if name.endswith('/gazebo/world_outlines'))]
