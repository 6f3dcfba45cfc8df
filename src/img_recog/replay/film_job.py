"""The program film: makes a film of a bag that was recorded in the running system."""
import argparse
import logging
import math
import os
from typing import Any, List, Optional, Sequence, Tuple

import numpy as np
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tqdm import tqdm
from visualization_msgs.msg import MarkerArray

from img_recog import files
from img_recog.command_line import programs
from img_recog.command_line.programs import allowed
from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import MAX_NUMBER, PoseError
from img_recog.errors import counted
from img_recog.formats import still_images
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recordings.bags import BagFrames
from img_recog.recordings.frames import SECOND_NS
from img_recog.replay.bag_messages import Messages
from img_recog.replay.film import Film
from img_recog.replay.film_picture import FilmPicture

_BAG_ADVICE = 'give a bag with images, as of ./run demo record:=FILE'
_KINDS = {'odom': Odometry, 'scan': LaserScan, 'cmd_vel': Twist, 'outlines': MarkerArray}
_log = logging.getLogger('film.py')


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the program; return its exit code."""
    return programs.run('film.py', _make, 'cannot make the film', arguments)


def _make(arguments: List[str], interrupts: Interrupts) -> str:
    options = _options(arguments)
    path, output = os.path.expanduser(options.bag), os.path.expanduser(options.output)
    files.refuse_input(output, path, 'filmed', 'give the film another name')
    settings = parameter_file.read_or_default(options.colors)
    frames = BagFrames(path, options.topic, options.max_image_pixels, advice=_BAG_ADVICE)
    with frames.bag, files.atomic_write([output], 'give a path that can be written') as (file,):
        messages = Messages(path, frames.bag, frames.topic, _KINDS,
                            {frames.topic: ('image', frames.message_type)})
        if messages.others:
            _log.warning('the film does not show %s', messages.others)
        with interrupts.deferred():     # the destructor of tqdm fails after half a constructor
            progress = tqdm(total=frames.expected, unit=' images', disable=None)
        with Film(file, settings, messages.outlines()) as film:
            with progress:
                end_s, images = _fill(film, messages, frames, progress)
            film.close(end_s)
    return '{}: {:.1f} s, {} of {}'.format(
        output, end_s, counted(images, 'image'), frames.topic)


def _fill(film: Film, messages: Messages, frames: BagFrames, progress: tqdm
          ) -> Tuple[float, int]:
    """Add all messages to a film; return its length in s, and the number of its images."""
    picture, start_s, time_s, number = film.picture, None, 0.0, 0
    for role, msg, recorded_s, _ in messages.in_order():
        if role == 'cmd_vel':
            picture.asked = _speed(msg)
        elif role == 'odom':
            _take_odometry(picture, msg)
        elif role == 'scan' and picture.pose is not None:
            picture.scan = scan_points(msg, picture.pose)
        elif role == 'image':
            progress.update()
            start_s = recorded_s if start_s is None else start_s
            last_s, time_s = time_s, recorded_s - start_s
            # the film would be as long as the gap
            frames.check_gap(number, round(last_s * SECOND_NS), round(time_s * SECOND_NS))
            decoded, number = frames.decoded(number, msg), number + 1
            if decoded is not None:
                film.add(time_s, *decoded)
    for line in frames.remarks.lines(frames.path):
        _log.warning('%s', line)
    return time_s, frames.remarks.used


def _take_odometry(picture: FilmPicture, msg: Any) -> None:
    try:
        picture.pose = plane_msgs.pose_from_msg(msg.pose)
    except PoseError:       # a film needs no warning for each message
        return
    picture.driven = _speed(msg.twist.twist)


def _speed(twist: Twist) -> float:
    """Return the speed in m/s; 0 if it cannot be drawn."""
    return twist.linear.x if abs(twist.linear.x) <= MAX_NUMBER else 0.0


def scan_points(msg: LaserScan, pose: Tuple[float, float, float]) -> np.ndarray:
    """Return the points (n, 2) of a scan in m, in the frame of the pose.

    As if the scanner were at the pose: for the map of a film, its place on the robot is too small.
    Points with a number that is not finite, or farther than MAX_NUMBER, are left out.

    >>> scan_points(LaserScan(range_max=3.5, ranges=[2.0, math.inf]), (1.0, 0.0, 0.0)).tolist()
    [[3.0, 0.0]]
    """
    # numpy warns of NaN and infinite numbers in comparisons and products
    if (not math.isfinite(msg.angle_min + msg.angle_increment + msg.range_min)
            or math.isnan(msg.range_max)):
        return np.empty((0, 2))
    ranges = np.array(msg.ranges, float)
    numbers = np.flatnonzero(np.isfinite(ranges))
    numbers = numbers[(ranges[numbers] >= max(msg.range_min, 0.0))
                      & (ranges[numbers] <= min(msg.range_max, MAX_NUMBER))]
    ranges, angles = ranges[numbers], pose[2] + msg.angle_min + numbers * msg.angle_increment
    return ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1) + pose[:2]


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = programs.parser(
        'film.py', 'Make a film of a recorded bag: camera, masked images, map '
        'and charts side by side.')
    parser.add_argument('bag', metavar='BAG', help='a bag with images, as of ./run demo '
                        'record:=FILE')
    parser.add_argument('output', metavar='FILE.mp4', help='where to write the film',
                        type=allowed(str, lambda path: path.lower().endswith('.mp4'), 'FILE.mp4'))
    parser.add_argument('--colors', default='', metavar='YAML',
                        help='parameter file of color_extract (default: the article\'s colors)')
    parser.add_argument('--topic', default='', help='topic of the images, if there are several')
    still_images.add_option(parser)
    return parser.parse_args(arguments)
