"""Runs the program replay: from its arguments to its files and its summary."""
import argparse
import contextlib
import functools
import logging
import os
import time
from typing import TYPE_CHECKING, Callable, List, Optional, Sequence, Tuple, Union

from tqdm import tqdm

from img_recog import files
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.camera_arguments import RATES, ROBOT
from img_recog.command_line import programs, results
from img_recog.command_line.programs import allowed
from img_recog.errors import UserError, counted
from img_recog.formats import still_images
from img_recog.loading import resources
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import recording_names
from img_recog.recordings.films import FilmFrames
from img_recog.recordings.frames import SECOND_NS
from img_recog.replay import scenario
from img_recog.replay.chain import Chain, ColorRecognition, Recognition, Recorder
from img_recog.replay.recorders import BagRecorder, PlotRecorder, TableRecorder
from img_recog.settings import SettingError
from img_recog.simulation.physics.body import Motion
from img_recog.simulation.pictures.footprints import footprints
from img_recog.simulation.simulation_settings import SpawnSettings
from img_recog.simulation.simulator import Simulator

if TYPE_CHECKING:
    from img_recog.recordings.bags import BagFrames
    from img_recog.replay.film import Film
    from img_recog.replay.robot_frames import RobotFrames

_EXTENSIONS = ('.bag', '.csv', '.png')
_MAX_SECONDS = 1e6
_log = logging.getLogger('replay.py')
Frames = Union[FilmFrames, 'BagFrames', 'RobotFrames']


def main(begin_s: float) -> int:
    """Run the program; return its exit code.

    begin_s: start time of the program, by time.perf_counter.
    """
    return programs.run('replay.py', lambda words, interrupts: replay(
        options_of(words), begin_s, interrupts), 'cannot write')


def replay(options: argparse.Namespace, begin_s: float, interrupts: Interrupts) -> str:
    """Run the replay given by the options; return its summary.

    begin_s: start time of the program, by time.perf_counter.
    interrupts: handles the signals that end the program.
    Raises UserError if it is not possible; no file is written then.
    """
    recording = None if options.camera else _open_input(options)
    make_recognition, settings = _recognition(options)
    name = os.path.expanduser(options.input) or 'robot_in_' + os.path.basename(options.world)
    extensions = _EXTENSIONS + (('.mp4',) if options.film else ())
    paths = files.output_paths(name, os.path.expanduser(options.output), extensions)
    simulator = scenario.build(
        world_name(options.world), os.path.expanduser(options.urdf),
        spawn_settings(options), options.allow_partial_world)
    frames = recording or _robot_frames(simulator, options.seconds)
    recognition = make_recognition(frames)
    robot, = simulator.robots
    plot = PlotRecorder(settings.colors)
    with files.atomic_write(paths) as (bag_file, csv_file, png_file, *film_files), \
            contextlib.ExitStack() as stack:
        bag = BagRecorder(bag_file, settings.color_names, robot.settings.sensors)
        table = TableRecorder(stack.enter_context(results.csv_table(
            csv_file, TableRecorder.head(settings.color_names))))
        recorders: List[Recorder] = [bag, table, plot]
        film: 'Optional[Film]' = None
        for file in film_files:
            # imported here because loading it takes time
            from img_recog.replay import film as films
            film = stack.enter_context(films.Film(file, settings, footprints(simulator.world)))
            recorders.append(films.FilmRecorder(film))
        start_s = time.perf_counter()
        chain = Chain(simulator, recognition, options.teleop, recorders)
        with interrupts.deferred():     # the destructor of tqdm fails after half a constructor
            progress = tqdm(chain.measured(frames), unit=' frames',
                            total=frames.expected or None, disable=None)
        with progress:
            end_ns = chain.run(progress) + frames.period_ns     # of a bag known after the last
            chain.end(end_ns)
        loop_s = time.perf_counter() - start_s
        bag.close()
        if film is not None:
            film.close(end_ns / SECOND_NS)
        # imported here because loading matplotlib takes time, and the loop may fail
        from img_recog.replay import figure
        figure.draw(png_file, 'Replay of {}, {}, in the world {}'.format(
            os.path.basename(options.input) or "the robot's camera", counted(plot.frames, 'frame'),
            os.path.basename(options.world)),
                            plot.data(end_ns / SECOND_NS, footprints(simulator.world)))
    for warning in frames.warnings + recognition.warnings:
        _log.warning('%s', warning)
    whole_s = time.perf_counter() - begin_s
    return _summary(plot.frames, end_ns / SECOND_NS, loop_s, whole_s, robot.body.motion(),
                    paths)


def _robot_frames(simulator: Simulator, seconds: float) -> 'RobotFrames':
    # imported here because loading OpenGL and trimesh takes time
    from img_recog.replay.robot_frames import RobotFrames
    return RobotFrames(simulator, scenario.camera_settings(simulator), seconds)


def _recognition(options: argparse.Namespace
                 ) -> Tuple[Callable[[Frames], Recognition], RecognitionSettings]:
    """Return what makes the recognition of an input, and the settings of its colors."""
    if not options.recognize:
        settings = parameter_file.read_or_default(options.colors)
        return lambda _: ColorRecognition(settings), settings
    # imported here because few need it
    from img_recog.camera import calibration
    from img_recog.recordings import camera_infos
    from img_recog.replay import function_recognition
    path = os.path.expanduser(options.calibration)
    try:
        given = camera_infos.of_calibration(
            calibration.load(path, functools.partial(_log.warning, '%s'))) if path else None
    except FileNotFoundError:
        raise UserError('--calibration: no file {}'.format(path))
    function = function_recognition.load(options.recognize)
    return lambda frames: function_recognition.FunctionRecognition(
        function, given or frames.camera_infos(), options.strict), RecognitionSettings()


def _summary(frames: int, simulated_s: float, loop_s: float, whole_s: float, motion: Motion,
             paths: Sequence[str]) -> str:
    return ('{}, {:.3f} s simulated in {:.2f} s, {:.1f} times real time ({:.2f} s with '
            'world and plot); the robot ends at x {:.3f} m, y {:.3f} m, yaw {:.3f} rad; wrote {}'
            .format(counted(frames, 'frame'), simulated_s, loop_s, simulated_s / loop_s, whole_s,
                    motion.position[0], motion.position[1], motion.yaw, ', '.join(paths)))


def _open_input(options: argparse.Namespace) -> Frames:
    path = os.path.expanduser(options.input)
    if recording_names.is_bag(path):
        # imported here because loading rosbag takes time
        from img_recog.recordings.bags import BagFrames
        return BagFrames(path, options.topic, options.max_image_pixels)
    if options.topic:
        raise UserError('cannot read {}: --topic is for a bag, and it is not a bag'.format(path))
    return FilmFrames(path, options.max_image_pixels, options.framerate)


def options_of(arguments: Sequence[str]) -> argparse.Namespace:
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
    parser.add_argument('--camera', choices=[ROBOT], default='',
                        help='robot: instead of a video, the images of a camera on the robot, '
                        'which moves by what it sees')
    parser.add_argument('--seconds', type=float, default=60.0,
                        help='simulated time with --camera (default: %(default)s)')
    recording_names.add_topic(parser)
    parser.add_argument('--framerate', metavar='HZ', default=UsbCamSettings.framerate,
                        type=allowed(float, RATES.accepts, RATES.text),
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
    recording_names.add_output(parser, 'NAME.replay.bag, .csv and .png')
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
