"""What is kept of a simulation whose test has failed: pictures, a film, and the log."""
import contextlib
import os
import re
import sys
import time
from collections import deque
from typing import Deque, Iterable, List, NamedTuple, Optional, Sequence

import cv2
import numpy as np
from sensor_msgs.msg import Image

from img_recog import files
from img_recog.conversions import image_msgs
from img_recog.errors import UserError, one_line
from img_recog.recognition.parameter_file import COLORS
from img_recog.recognition.recognition_settings import (DEFAULT_COLORS, RecognitionSettings,
                                                        color_names, with_colors)
from img_recog.ros import parameters
from img_recog.testing.topics import Pose

_PERIOD_S, _FILM_S = 0.1, 30.0      # simulated, between two moments, and of a film
_MAX_WIDTH = 320
_RESULT_OPTIONS = ('--gtest_output=xml:', '--junitxml=', '--junit-xml=')
_BEGAN_S = time.time()       # files that are newer are of this run
_HEAD = b'the last lines of the nodes of a test that has failed\n'
_ADVICE = 'give Simulation another folder: results='
SUFFIXES = '.log', '.camera.png', '.above.png', '.mp4'
results_file = ''       # of pytest, if the plugin fixtures.py has found it


def folder(given: str) -> str:
    """Return the folder for files: as given, or that of the file for results, or the current one.

    It is made. Raises UserError if it cannot be.
    """
    options = (word[len(option):] for word in sys.argv for option in _RESULT_OPTIONS
               if word.startswith(option))
    path = os.path.abspath(os.path.expanduser(
        given or os.path.dirname(results_file or next(options, '')) or '.'))
    try:
        os.makedirs(path, exist_ok=True)
    except OSError as error:
        raise UserError('cannot make {}: {}'.format(path, one_line(error)), _ADVICE) from None
    return path


def name(given: str) -> str:
    """Return the beginning of the names of files: as given, or the name of the test that runs."""
    test = os.environ.get('PYTEST_CURRENT_TEST', '').rpartition(' ')[0].rpartition('::')[2]
    program = os.path.splitext(os.path.basename(sys.argv[0] if sys.argv else ''))[0]
    return re.sub(r'[^\w.-]+', '_', given or test or program).strip('_') or 'simulation'


def remove_old(path: str) -> None:
    """Remove the files of an earlier process whose paths begin so; not others of these names."""
    with contextlib.suppress(OSError):
        with open(path + SUFFIXES[0], 'rb') as log:
            is_ours = log.read(len(_HEAD)) == _HEAD
        if is_ours and os.path.getmtime(log.name) < _BEGAN_S:
            for suffix in reversed(SUFFIXES):       # last the one that tells whose they are
                with contextlib.suppress(FileNotFoundError):
                    os.remove(path + suffix)


class Moment(NamedTuple):
    """What a film shows at a time. asked: speed in m/s; jpeg: the image of the camera."""

    pose: Pose
    asked: float
    jpeg: Optional[np.ndarray]


class LastMoments:
    """Keeps the last moments for a film."""

    def __init__(self) -> None:
        self._moments: Deque[Moment] = deque(maxlen=round(_FILM_S / _PERIOD_S))

    def add(self, pose: Pose, asked: float, msg: Optional[Image]) -> None:
        """Keep a moment, if its time has come. msg: the image of the camera."""
        if self._moments and 0 <= pose.time_s - self._moments[-1].pose.time_s < _PERIOD_S - 0.001:
            return
        jpeg = None
        if msg is not None:
            image = image_msgs.from_msg(msg)
            scale = min(1.0, _MAX_WIDTH / image.shape[1])
            small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            jpeg = cv2.imencode('.jpg', small)[1]
        self._moments.append(Moment(pose, asked, jpeg))

    def write_film(self, path: str, outlines: Sequence[np.ndarray],
                   colors: RecognitionSettings) -> None:
        """Write a film. Raises UserError, also if there are no moments.

        outlines: of what stands in the world, (corners, 2) in m. colors: that are recognized.
        """
        moments = list(self._moments)
        from img_recog.replay.film import Film      # a fifth of the start, for tests that fail
        # time has been reset, or gone back, since then
        start = max((number for number in range(1, len(moments))
                     if moments[number].pose.time_s < moments[number - 1].pose.time_s), default=0)
        moments = moments[start:]
        if not moments:
            raise UserError('no film: there was no odometry')
        image = np.zeros((240, _MAX_WIDTH, 3), np.uint8)
        with files.atomic_write([path], _ADVICE) as (file,), \
                Film(file, colors, outlines) as film:
            for pose, asked, jpeg in moments:
                if jpeg is not None:
                    image = cv2.imdecode(jpeg, cv2.IMREAD_COLOR)
                film.picture.pose = pose[:3]
                film.picture.asked, film.picture.driven = asked, pose.linear
                film.add(pose.time_s - moments[0].pose.time_s, image, 'bgr8')
            film.close(moments[-1].pose.time_s - moments[0].pose.time_s)


def colors_of(nodes: Iterable[str]) -> RecognitionSettings:
    """Return the colors of the first of the nodes that recognizes some; none if no node does."""
    for node in nodes:
        if 'min_blob_size' in parameters.names_in(node):    # color_extract writes what it uses
            names = parameters.read_one(COLORS, list(DEFAULT_COLORS), color_names, node)
            return parameters.read(with_colors(names), namespace=node)
    return with_colors(())()


def write_picture(path: str, msg: Image) -> None:
    """Write a PNG of an image. Raises UserError."""
    with files.atomic_write([path], _ADVICE) as (file,):
        file.write(cv2.imencode('.png', image_msgs.from_msg(msg))[1].tobytes())


def write_log(path: str, lines: List[str]) -> None:
    """Write lines of the nodes. Raises UserError."""
    with files.atomic_write([path], _ADVICE) as (file,):
        file.write(_HEAD + ''.join(line + '\n' for line in lines).encode())
