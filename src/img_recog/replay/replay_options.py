"""The command line options of the program replay."""
import argparse
import os
from typing import Sequence

from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.command_line import programs
from img_recog.command_line.option_types import allowed
from img_recog.errors import UserError
from img_recog.formats import still_images
from img_recog.loading import resources
from img_recog.recordings import recording_names
from img_recog.settings import SettingError
from img_recog.simulation.simulation_settings import SpawnSettings

_MAX_SECONDS = 1e6


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options: those below, and the input and the initial pose.

    Raises UserError for some that make no sense together.
    """
    parser = _parser()
    options = parser.parse_args(arguments)
    if bool(options.input) == bool(options.camera):
        parser.error('give RECORDING or --camera robot')
    if not 0 < options.seconds <= _MAX_SECONDS:
        parser.error('argument --seconds: got {:g}, allowed is more than 0 and at most {:g}'
                     .format(options.seconds, _MAX_SECONDS))
    _check_recognize(options)
    return options


def _check_recognize(options: argparse.Namespace) -> None:
    """Raise UserError for options that make no sense together."""
    if options.recognize and options.colors:
        raise UserError('--colors is for the color recognition, and --recognize replaces it',
                        'leave one of them out')
    for name in ('strict', 'calibration'):
        if getattr(options, name) and not options.recognize:
            raise UserError('--{} is for --recognize, which is missing'.format(name))
    if options.calibration and options.camera:
        raise UserError('--calibration is for a recording, and --camera robot has its own one')


def world_name(name: str) -> str:
    """Return the absolute path of a world file in the current folder; other names as they are."""
    path = os.path.abspath(os.path.expanduser(name))
    return path if name != resources.DEFAULT_WORLD and os.path.isfile(path) else name


def spawn_settings(options: argparse.Namespace) -> SpawnSettings:
    """Return the initial pose of the robot; raise UserError for a number that is not allowed."""
    try:
        return SpawnSettings(options.x_pos, options.y_pos, options.z_pos, options.yaw)
    except SettingError as error:
        raise UserError('--{}: got {}, allowed is {}'.format(
            error.name.replace('_', '-'), error.got, error.allowed))


def _parser() -> argparse.ArgumentParser:
    spawn = SpawnSettings()
    parser = programs.parser(
        'replay.py', 'Run a video or a bag through the color recognition '
        'and the simulated robot, as fast as possible and without a ROS master; write the result '
        'as a bag, a table (CSV) and a picture (PNG).')
    parser.add_argument('input', metavar='RECORDING', nargs='?', default='',
                        help='a video, a folder of pictures, or a bag with images')
    parser.add_argument('--camera', choices=['robot'], default='',
                        help='robot: instead of a video, the images of a camera on the robot, '
                        'which moves by what it sees')
    parser.add_argument('--seconds', type=float, default=60.0,
                        help='simulated time with --camera (default: %(default)s)')
    recording_names.add_topic(parser)
    parser.add_argument('--framerate', metavar='HZ', default=UsbCamSettings.framerate,
                        type=allowed(float, lambda rate_hz: 0.1 <= rate_hz <= 1000,
                                     'from 0.1 to 1000'),
                        help='of a folder of pictures (default: %(default)g)')
    still_images.add_option(parser)
    parser.add_argument('--colors', default='', metavar='YAML',
                        help='parameter file of color_extract (default: the article\'s colors)')
    parser.add_argument('--recognize', default='', metavar='MODULE:FUNCTION',
                        help='a function in place of the color recognition; also '
                        'FILE.py:FUNCTION')
    parser.add_argument('--strict', action='store_true',
                        help='with --recognize: end at the first frame for which it fails')
    parser.add_argument('--calibration', default='', metavar='YAML',
                        help='with --recognize: calibration of the camera of the recording')
    parser.add_argument('--output', default='', metavar='FOLDER_OR_PREFIX',
                        help='where to write the files (default: NAME.replay.bag, .csv and .png '
                        'in the current folder)')
    parser.add_argument('--film', action='store_true',
                        help='also write a film, NAME.replay.mp4, of camera, masked images, map '
                        'and charts')
    parser.add_argument('--no-teleop', dest='teleop', action='store_false',
                        help='do not send the zeros of the idle teleop: each command holds until '
                        'the next one')
    parser.add_argument('--world', default=resources.DEFAULT_WORLD,
                        help='turtlebot3_world, color_posts, empty, a world of turtlebot3_gazebo, '
                        'or a URDF or SDF file (default: %(default)s)')
    parser.add_argument('--allow-partial-world', action='store_true',
                        help='load a world without what is not found of it')
    parser.add_argument('--urdf', default=resources.burger(),
                        help='URDF file of the robot (default: the TurtleBot3 burger)')
    for name, unit in (('x_pos', 'm'), ('y_pos', 'm'), ('z_pos', 'm'), ('yaw', 'rad')):
        parser.add_argument(
            '--' + name.replace('_', '-'), type=float, metavar=unit.upper(),
            default=getattr(spawn, name),
            help='initial pose of the robot in {} (default: %(default)s)'.format(unit))
    return parser
