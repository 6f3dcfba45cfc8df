"""The program plot: draws a drive, of a bag or of the running system, as replay.py does."""
import argparse
import contextlib
import itertools
import logging
import math
import os
import tempfile
import time
from typing import Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import rosgraph
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud
from tqdm import tqdm
from visualization_msgs.msg import MarkerArray

from img_recog import files
from img_recog.command_line import programs
from img_recog.command_line.programs import allowed
from img_recog.conversions import color_detection_msgs, plane_msgs, twist_msgs
from img_recog.conversions.plane_msgs import MAX_NUMBER
from img_recog.errors import UserError, counted, one_line, shortened
from img_recog.processes.bag_recording import BagRecording
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import Color, RecognitionSettings
from img_recog.recordings.bag_file import BagFile, open_bag
from img_recog.replay import figure
from img_recog.replay.bag_messages import Messages
from img_recog.replay.plot_data import PlotColor, PlotData, X, Y
from img_recog.ros import timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master

_ODOM = 'odom'
_OTHERS = {'cmd_vel': Twist, 'detections': PointCloud, 'outlines': MarkerArray}
_JUMP_M = 0.5           # between two positions that follow one another: the robot was moved
_HUE_STEP = 50          # between colors of which only the names are known
_SECONDS, _MAX_SECONDS = 20.0, 86400.0
_TICK_S, _TIMEOUT_S = 0.2, 3.0
_NODE = '/img_recog_plot'
_BAG_ADVICE = 'give a bag, as of ./run demo record:=FILE, or none to record the running system'
_MASTER_ADVICE = 'start the demo first, or set ROS_MASTER_URI; or give a bag'
_ERRORS = (*timed_xmlrpc.ERRORS, ValueError, TypeError)
_log = logging.getLogger('plot.py')


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


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the program; return its exit code."""
    return programs.run('plot.py', _make, 'cannot draw', arguments)


def _make(arguments: List[str], _: Interrupts) -> str:
    options = _options(arguments)
    path, output = os.path.expanduser(options.bag), os.path.expanduser(options.output)
    settings = parameter_file.read_or_default(options.colors)
    if path:
        files.refuse_input(output, path, 'drawn', 'give the picture another name')
    with contextlib.ExitStack() as stack:
        file, = stack.enter_context(files.atomic_write(
            [output], 'give a path that can be written'))
        title, odometry = os.path.basename(path), ''
        if not path:
            title = 'the running system'
            with _master() as master:
                types = dict(master.call('getPublishedTopics', ''))
                odometry = odometry_of(types, options.robot, title)
                if not options.colors:
                    node = odometry.rpartition('/')[0] + '/color_extract'
                    settings = _running_settings(master, node) or settings
            path = stack.enter_context(_recorded(
                topics_beside(odometry, types), options.duration))
        with open_bag(path, advice=_BAG_ADVICE) as bag:
            types = {name: kind for name, kind, _ in sorted(bag.connections())}
            odometry = odometry or odometry_of(types, options.robot, title)
            data, others = drive_of(title, bag, odometry, settings.colors)
            for line in bag.remarks(types):
                _log.warning('%s', line)
        if others:
            _log.warning('the picture does not show %s', others)
        figure.draw(file, 'Drive of {}, {:.1f} s'.format(title, data.end_s), data)
    return '{}: {:.1f} s, {}, {}'.format(
        output, data.end_s, counted(len(data.motion), 'pose'),
        counted(len(data.commands) + len(data.idle), 'command'))


@contextlib.contextmanager
def _master() -> Iterator[Master]:
    """Yield the calls of the master; raise UserError if it does not answer."""
    uri = rosgraph.get_master_uri()
    try:
        with Master(uri, _NODE, _TIMEOUT_S) as master:
            yield master
    except _ERRORS as error:
        raise UserError('no master answers at {}: {}'.format(shortened(uri), one_line(error)),
                        _MASTER_ADVICE)


def _running_settings(master: Master, node: str) -> Optional[RecognitionSettings]:
    """Return the settings of the colors that a node has as parameters, None without them."""
    try:
        parameters = master.ask('getParam', node)
        return None if parameters is None else parameter_file.settings_in(parameters, node)
    except UserError as error:
        _log.warning('the limits are those of the article: %s', one_line(error))
        return None


@contextlib.contextmanager
def _recorded(topics: Sequence[str], seconds: float) -> Iterator[str]:
    """Record topics until the time is over, or Ctrl-C; yield the path of a bag for the `with`."""
    with tempfile.TemporaryDirectory(prefix='img_recog_plot_') as folder:
        recording = BagRecording(os.path.join(folder, 'drive.bag'), topics)
        try:
            end_s = time.monotonic() + seconds
            with contextlib.suppress(KeyboardInterrupt), tqdm(
                    total=seconds, desc='recording, Ctrl-C ends it', disable=None,
                    bar_format='{desc}: {n:.0f} of {total:.0f} s') as progress:
                while time.monotonic() < end_s and not recording.check():
                    time.sleep(_TICK_S)
                    progress.update(_TICK_S)
        finally:
            recording.stop()
        yield recording.path


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = programs.parser(
        'plot.py', 'Draw areas, commands, speed and path of a robot, as '
        'replay.py does: of a recorded bag, or of the running system from now on.')
    parser.add_argument('bag', metavar='BAG', nargs='?', default='',
                        help='a bag with odometry; without it, the running system is recorded')
    parser.add_argument('output', metavar='FILE.png', help='where to write the picture',
                        type=allowed(str, lambda path: path.lower().endswith('.png'), 'FILE.png'))
    parser.add_argument('--duration', default=_SECONDS, metavar='S', type=allowed(
                            float, lambda seconds: 0 < seconds <= _MAX_SECONDS,
                            'more than 0 and at most {:g}'.format(_MAX_SECONDS)),
                        help='how long to record the running system, s; Ctrl-C ends it earlier '
                        '(default: %(default)g)')
    parser.add_argument('--robot', default='', metavar='NAME',
                        help='namespace of the robot, if there are several')
    parser.add_argument('--colors', default='', metavar='YAML',
                        help='parameter file of color_extract, for the limits (default: those of '
                        'the running node, or of the article)')
    return parser.parse_args(arguments)
