"""The program film: makes a film of a bag that was recorded in the running system."""
import argparse
import contextlib
import itertools
import logging
import math
import os
import signal
import sys
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple

import cv2
import numpy as np
from tqdm import tqdm

from img_recog import files, still_images
from img_recog.conversions import plane_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.conversions.plane_msgs import PoseError
from img_recog.errors import UserError, one_line
from img_recog.recognition import parameter_file
from img_recog.recognition.settings import RecognitionSettings, with_colors
from img_recog.replay.arguments import without_special_keys
from img_recog.replay.bags import DAMAGE_ERRORS, BagFrames, damaged
from img_recog.replay.chain import SECOND_NS
from img_recog.replay.film import Film
from img_recog.replay.inputs import WANTED, is_bag
from img_recog.replay.signals import Interrupts

_BAG_ADVICE = 'give a bag with images, as of ./run demo record:=FILE'
_COLORS_ADVICE = 'give a parameter file of color_extract, like config/colors.yaml'
_LOG_SILENT = 0         # cv2.utils.logging.LOG_LEVEL_SILENT
_KINDS = {'odom': 'nav_msgs/Odometry', 'scan': 'sensor_msgs/LaserScan',
          'cmd_vel': 'geometry_msgs/Twist', 'outlines': 'visualization_msgs/MarkerArray'}
# the ends of their usual names; of outlines, only these are of the world
_USUAL = {'odom': 'odom', 'scan': 'scan', 'cmd_vel': 'cmd_vel', 'outlines': 'world_outlines'}
_log = logging.getLogger('film.py')


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the program; return its exit code."""
    logging.basicConfig(format='film.py: %(levelname)s: %(message)s')
    cv2.setLogLevel(_LOG_SILENT)
    words = sys.argv[1:] if arguments is None else arguments
    options = _options(without_special_keys(words))
    interrupts = Interrupts()
    try:
        sys.stdout.write(_make(options, interrupts) + '\n')
    except UserError as error:
        _log.error('%s', one_line(error))
        return 1
    except OSError as error:
        _log.error('%s: %s', error.filename or 'cannot make the film', one_line(error))
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    return 0


def _make(options: argparse.Namespace, interrupts: Interrupts) -> str:
    path, output = os.path.expanduser(options.bag), os.path.expanduser(options.output)
    _check_bag(path)
    files.refuse_input(output, path, 'filmed', 'give the film another name')
    settings = _settings(options.colors)
    frames = _frames(path, options)
    with frames.bag, files.atomic_write(
            [output], 'give a path that can be written') as (file,), \
            contextlib.ExitStack() as stack:
        messages = _Messages(path, frames)
        outlines = messages.outlines()
        with interrupts.deferred():     # or else ffmpeg may be started and not be ended
            film = stack.enter_context(Film(file, settings, outlines, output))
        with interrupts.deferred():     # the destructor of tqdm fails after half a constructor
            progress = tqdm(total=frames.expected, unit=' images', disable=None)
        with progress:
            end_s = _fill(film, messages, frames, progress)
        film.close(end_s)
    return '{}: {:.1f} s, {} images of {}'.format(output, end_s, messages.images, frames.topic)


def _check_bag(path: str) -> None:
    """Raise UserError if a file cannot be a bag."""
    try:
        is_usable = os.path.isfile(path) and is_bag(path)
    except OSError as error:
        raise UserError('cannot read {}: {}'.format(path, one_line(error).lower()),
                        'see its permissions (ls -l), or give another bag')
    if not is_usable:
        raise UserError('cannot make a film of {}: {}'.format(
            path, 'it is not a bag' if os.path.exists(path) else 'no such file'), _BAG_ADVICE)


def _frames(path: str, options: argparse.Namespace) -> BagFrames:
    try:
        return BagFrames(path, options.topic, options.max_image_pixels)
    except UserError as error:
        if error.advice != WANTED:
            raise
        raise UserError(error.problem, _BAG_ADVICE)     # not a video, as for replay.py


def _settings(path: str) -> RecognitionSettings:
    if not path:
        return with_colors()()
    try:
        return parameter_file.read(os.path.expanduser(path))
    except UserError as error:
        raise UserError(error.problem, error.advice or _COLORS_ADVICE)


class _Messages:
    """The messages of a bag that a film shows.

    path: of the bag; images: number of images so far.
    """

    def __init__(self, path: str, frames: BagFrames):
        self.path, self._bag = path, frames.bag
        self.images = 0
        kinds = {name: topic.msg_type
                 for name, topic in self._bag.get_type_and_topic_info().topics.items()}
        self._roles: Dict[str, str] = {frames.topic: 'image'}
        for role, kind in _KINDS.items():
            found = sorted(name for name in kinds if kinds[name] == kind)
            usual = [name for name in found if name.endswith(_USUAL[role])]
            if usual or found and role != 'outlines':
                self._roles[_nearest(usual or found, frames.topic)] = role

    def outlines(self) -> List[np.ndarray]:
        """Return the outlines of what stands in the world; none if they were not recorded."""
        for role, msg, _ in self._read(['outlines']):
            return plane_msgs.outlines_from_msg(msg)
        return []

    def in_order(self) -> Iterator[Tuple[str, Any, float]]:
        """Yield role, message and time of recording in s, without the outlines."""
        return self._read(['image', 'odom', 'scan', 'cmd_vel'])

    def _read(self, roles: Sequence[str]) -> Iterator[Tuple[str, Any, float]]:
        topics = [name for name, role in self._roles.items() if role in roles]
        if not topics:
            return
        try:
            for name, msg, time in self._bag.read_messages(topics):
                yield self._roles[name], msg, time.to_sec()
        except DAMAGE_ERRORS as error:
            raise damaged(self.path, error)


def _nearest(names: Sequence[str], topic: str) -> str:
    """Return the name that shares most namespaces with a topic: it is of the same robot."""
    parts = topic.split('/')

    def shared(name: str) -> int:
        pairs = zip(name.split('/'), parts)
        return sum(1 for _ in itertools.takewhile(lambda pair: pair[0] == pair[1], pairs))
    return max(names, key=shared)


def _fill(film: Film, messages: _Messages, frames: BagFrames, progress: tqdm) -> float:
    """Add all messages to a film; return its length in s."""
    start_s, time_s, last_problem, number = None, 0.0, '', 0
    for role, msg, recorded_s in messages.in_order():
        if role == 'cmd_vel':
            film.asked = msg.linear.x if math.isfinite(msg.linear.x) else 0.0
        elif role == 'odom':
            _take_odometry(film, msg)
        elif role == 'scan' and film.pose is not None:
            film.scan = _points(msg, film.pose)
        elif role == 'image':
            progress.update()
            start_s = recorded_s if start_s is None else start_s
            last_s, time_s, number = time_s, recorded_s - start_s, number + 1
            # the film would be as long as the gap
            frames.check_gap(number, round(last_s * SECOND_NS), round(time_s * SECOND_NS))
            try:
                film.add(time_s, *frames.decode(msg))
                messages.images += 1
            except ImageError as error:
                last_problem = one_line(error)
    if not messages.images:
        raise UserError('no image on {} in {} can be used; {}'.format(
            frames.topic, messages.path, last_problem or 'there is no message'))
    if last_problem:
        _log.warning('%d of %d images cannot be used; the last is %s',
                     frames.expected - messages.images, frames.expected, last_problem)
    return time_s


def _take_odometry(film: Film, msg: Any) -> None:
    try:
        film.pose = plane_msgs.pose_from_msg(msg.pose)
    except PoseError:       # a film needs no warning for each message
        return
    speed = msg.twist.twist.linear.x
    film.driven = speed if math.isfinite(speed) else 0.0


def _points(msg: Any, pose: Tuple[float, float, float]) -> np.ndarray:
    """Return the points (n, 2) of a scan in m, in the frame of the pose.

    As if the scanner were at the pose: for the map of a film, its place on the robot is too small.
    """
    ranges = np.array(msg.ranges, float)
    angles = pose[2] + msg.angle_min + np.arange(len(ranges)) * msg.angle_increment
    is_hit = (ranges >= msg.range_min) & (ranges <= msg.range_max) & np.isfinite(angles)
    ranges, angles = ranges[is_hit], angles[is_hit]
    return ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1) + pose[:2]


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='film.py', description='Make a film of a recorded bag: camera, masked images, map '
        'and charts side by side.', allow_abbrev=False)
    parser.add_argument('bag', metavar='BAG', help='a bag with images, as of ./run demo '
                        'record:=FILE')
    parser.add_argument('output', metavar='FILE.mp4', type=_mp4, help='where to write the film')
    parser.add_argument('--colors', default='', metavar='YAML',
                        help='parameter file of color_extract (default: the article\'s colors)')
    parser.add_argument('--topic', default='', help='topic of the images, if there are several')
    still_images.add_option(parser)
    return parser.parse_args(arguments)


def _mp4(text: str) -> str:
    if not text.lower().endswith('.mp4'):
        raise argparse.ArgumentTypeError('got {!r}, expected FILE.mp4'.format(text))
    return text
