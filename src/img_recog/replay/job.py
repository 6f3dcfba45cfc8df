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
from img_recog.command_line import programs
from img_recog.command_line import results
from img_recog.errors import UserError, counted
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import recording_names
from img_recog.recordings.films import FilmFrames
from img_recog.recordings.frames import SECOND_NS
from img_recog.replay import replay_options, scenario
from img_recog.replay.chain import ColorRecognition, Recognition, Recorder
from img_recog.replay.loop import Loop
from img_recog.replay.recorders import BagRecorder, PlotRecorder, TableRecorder
from img_recog.simulation.assembly import Assembly
from img_recog.simulation.physics.body import Motion
from img_recog.simulation.physics.footprints import footprints

if TYPE_CHECKING:
    from img_recog.recordings.bags import BagFrames
    from img_recog.replay.film import Film
    from img_recog.replay.robot_frames import RobotFrames

_EXTENSIONS = ('.bag', '.csv', '.png')
_log = logging.getLogger('replay.py')
Frames = Union[FilmFrames, 'BagFrames', 'RobotFrames']


def main(begin_s: float) -> int:
    """Run the program; return its exit code.

    begin_s: start time of the program, by time.perf_counter.
    """
    return programs.run('replay.py', lambda words, interrupts: replay(
        replay_options.parse(words), begin_s, interrupts), 'cannot write')


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
    built = scenario.build(
        replay_options.world_name(options.world), os.path.expanduser(options.urdf),
        replay_options.spawn_settings(options), options.allow_partial_world)
    frames = recording or _robot_frames(built, options.seconds)
    recognition = make_recognition(frames)
    simulator = built.simulator
    vehicle, = simulator.vehicles
    plot = PlotRecorder(settings.colors)
    with files.atomic_write(paths) as (bag_file, csv_file, png_file, *film_files), \
            contextlib.ExitStack() as stack:
        bag = BagRecorder(bag_file, settings.color_names, vehicle.settings.sensors)
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
        loop = Loop(simulator, frames, recognition, options.teleop, recorders)
        with interrupts.deferred():     # the destructor of tqdm fails after half a constructor
            progress = tqdm(loop.measurements, unit=' frames', total=frames.expected or None,
                            disable=None)
        with progress:
            end_ns = loop.run(progress)
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
    return _summary(plot.frames, end_ns / SECOND_NS, loop_s, whole_s, vehicle.robot.motion(),
                    paths)


def _robot_frames(built: Assembly, seconds: float) -> 'RobotFrames':
    # imported here because loading OpenGL and trimesh takes time
    from img_recog.replay.robot_frames import RobotFrames
    return RobotFrames(built, scenario.camera_settings(built), seconds)


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
