"""The command line of the program replay."""
import argparse
import os
from typing import Sequence

from img_recog import resources
from img_recog.errors import UserError
from img_recog.replay.inputs import DEFAULT_TOPICS
from img_recog.settings import SettingError
from img_recog.simulation.settings import SpawnSettings


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options: input, topic, colors, output, teleop, world, urdf and the start pose."""
    return _parser().parse_args(arguments)


def world_of(name: str) -> str:
    """Return a world that names a file from here by its absolute path."""
    path = os.path.abspath(os.path.expanduser(name))
    return path if name != resources.DEFAULT_WORLD and os.path.isfile(path) else name


def spawn_of(options: argparse.Namespace) -> SpawnSettings:
    """Return where the robot starts; UserError for a number that is not allowed."""
    try:
        return SpawnSettings(options.x_pos, options.y_pos, options.z_pos, options.yaw)
    except SettingError as error:
        raise UserError('--{}: got {}, allowed is {}'.format(
            error.name.replace('_', '-'), error.got, error.allowed))


def _parser() -> argparse.ArgumentParser:
    spawn = SpawnSettings()
    parser = argparse.ArgumentParser(
        prog='replay.py', description='Run a video or a bag through color recognition and the '
        'simulated robot, as fast as it goes and without a master; write a bag, a table (CSV) '
        'and a picture (PNG) of it.', allow_abbrev=False)
    parser.add_argument('input', metavar='VIDEO_OR_BAG')
    parser.add_argument('--topic', default='', help='images of a bag; default: {}, or the only '
                        'ones in it'.format(' or '.join(DEFAULT_TOPICS)))
    parser.add_argument('--colors', default='', metavar='YAML',
                        help='parameters of color_extract; default: those of the article')
    parser.add_argument('--output', default='', metavar='FOLDER_OR_PREFIX',
                        help='where to write; default: NAME.replay.bag, .csv and .png in the '
                        'current folder')
    parser.add_argument('--no-teleop', dest='teleop', action='store_false',
                        help='without the zeros of the idle teleop: a command holds until the '
                        'next one')
    parser.add_argument('--world', default=resources.DEFAULT_WORLD,
                        help='turtlebot3_world, empty, or the path of a URDF or SDF file')
    parser.add_argument('--urdf', default=resources.burger(), help='of the robot')
    for name, unit in (('x_pos', 'm'), ('y_pos', 'm'), ('z_pos', 'm'), ('yaw', 'rad')):
        parser.add_argument('--' + name.replace('_', '-'), type=float, metavar=unit.upper(),
                            default=getattr(spawn, name),
                            help='where the robot starts; default: %(default)s {}'.format(unit))
    return parser
