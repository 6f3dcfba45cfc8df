"""The command line of tune_colors: a picture that shows why a color is recognized, or why not.

For a file it is not a node and needs no master; for a topic it is an anonymous node, see
TuneColorsNode.
"""
import argparse
import os
import sys
from typing import Optional, Sequence

import cv2
import numpy as np
import rosgraph
import rospy

from img_recog import files, still_images
from img_recog.camera import selection
from img_recog.camera.image_source import read_image
from img_recog.camera.source import SourceEnded, SourceError, SourceTooLarge
from img_recog.errors import UserError, one_line
from img_recog.nodes.tune_colors.node import TuneColorsNode
from img_recog.nodes.tune_colors.output import PictureOutput
from img_recog.option_types import allowed
from img_recog.recognition import parameter_file
from img_recog.recognition.settings import with_colors
from img_recog.ros import image_topics, lifecycle

_OUTPUT = 'tune_colors.png'
_TIMEOUT_S = 10.0
_ANY_RATE_HZ = 30.0     # of no effect: frames are read one by one
_ADVICE = 'give an image, a video or the name of a topic with images'


def _tune_file(path: str, options: argparse.Namespace, picture: PictureOutput) -> None:
    if options.watch:
        raise UserError('--watch needs a topic, but {} is a file'.format(path))
    settings = (parameter_file.read(files.find_user_path(options.colors)) if options.colors
                else with_colors()())
    picture.begin(_image_in(path, options.frame or 0, options.max_image_pixels), settings)
    if picture.window is not None:
        picture.window.wait()


def _image_in(path: str, number: int, max_pixels: int) -> np.ndarray:
    """Return an image file, or frame `number` of a video file, in bgr8.

    Raises UserError if the file cannot be read or has no such frame.
    """
    image = read_image(path, max_pixels)
    if image is not None:
        if number:
            raise UserError('{} is an image and has no frame {}'.format(path, number))
        return image
    try:
        video = selection.open_file(path, _ANY_RATE_HZ, loop=False, max_pixels=max_pixels)
    except SourceTooLarge:
        raise
    except SourceError as error:        # its own advice is for a camera node
        raise SourceError(error.problem, _ADVICE)
    try:
        for _ in range(number):
            video.read()
        return cv2.cvtColor(video.read(), cv2.COLOR_RGB2BGR)
    except SourceEnded as error:
        raise UserError('there is no frame {}, counted from 0: {}'.format(number, error))
    finally:
        video.close()


def _tune(options: argparse.Namespace) -> int:
    name = options.image_or_topic
    picture = PictureOutput(files.user_output_path(options.output), not options.no_window)
    path = files.find_user_path(name)
    if os.path.isfile(path):
        _tune_file(path, options, picture)
        return 0
    if os.path.exists(path):
        raise UserError('cannot use {}: it is neither a file nor a topic'.format(name), _ADVICE)
    if not rosgraph.names.is_legal_name(name) or not name:
        raise UserError('cannot open {}: no such file'.format(name or "''"), _ADVICE)
    if options.frame is not None:
        raise UserError('--frame needs a video, but there is no file {}'.format(name))
    topic = rosgraph.names.script_resolve_name('tune_colors', name)
    message_type = image_topics.kind_of(topic)
    return lifecycle.run(rosgraph.names.anonymous_name('tune_colors'),
                         lambda: TuneColorsNode(topic, message_type, options, picture).spin())


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='tune_colors.py', description='Show why a color is recognized in an image, or why '
        'not: write a picture with the frame, masks and histograms, and show it in a window if '
        'there is a display.')
    parser.add_argument('image_or_topic', metavar='IMAGE_OR_TOPIC',
                        help='an image file, a video file, or a topic with images (a window '
                        'shows its newest image)')
    parser.add_argument('--frame', metavar='N', type=allowed(
                            int, lambda number: number >= 0, 'a whole number of at least 0'),
                        help='frame of a video, counted from 0 (default: 0)')
    colors = parser.add_mutually_exclusive_group()
    colors.add_argument('--colors', metavar='YAML', help='parameter file with the colors')
    colors.add_argument('--node', metavar='NAME', help='for a topic: the node whose '
                        'parameters define the colors (default: /color_extract; without '
                        'parameters, the article\'s colors)')
    parser.add_argument('--timeout', default=_TIMEOUT_S, metavar='S', type=allowed(
                            float, lambda seconds: seconds > 0, 'a number of seconds above 0'),
                        help='how long to wait for an image on a topic (default: %(default)g s)')
    still_images.add_option(parser)
    parser.add_argument('--output', default=_OUTPUT, metavar='PATH.png', type=allowed(
                            str, lambda path: path.lower().endswith('.png'),
                            'a path that ends in .png'),
                        help='where to write the picture (default: %(default)s)')
    parser.add_argument('--watch', action='store_true',
                        help='for a topic: write the picture every second until Ctrl-C')
    parser.add_argument('--no-window', action='store_true',
                        help='only write the picture, do not show it')
    return parser.parse_args(arguments)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the tool; return its exit code."""
    options = _options(rospy.myargv()[1:] if arguments is None else arguments)
    try:
        return _tune(options)
    except UserError as error:
        sys.stderr.write('tune_colors.py: {}\n'.format(one_line(error)))
        return 1
