"""From the arguments of the program replay to its files and its last line."""
import argparse
import io
import logging
import os
import signal
import sys
import time
from typing import TYPE_CHECKING, Iterable, Union

import cv2
from tqdm import tqdm

from img_recog import files
from img_recog.errors import UserError
from img_recog.recognition.settings import RecognitionSettings, with_colors
from img_recog.replay import cli, inputs, scenario
from img_recog.replay.chain import SECOND_NS, Chain, measured
from img_recog.replay.inputs import VideoFrames, is_bag, prefetch
from img_recog.replay.painter import Painter
from img_recog.replay.plot_recorder import PlotRecorder
from img_recog.replay.recorders import BagRecorder, TableRecorder
from img_recog.replay.signals import Interrupts
from img_recog.simulation.body import Motion
from img_recog.simulation.footprints import footprints

if TYPE_CHECKING:
    from img_recog.replay.bags import BagFrames

_EXTENSIONS = ('.bag', '.csv', '.png')
_PREFETCHED = 8                      # frames
_FATAL, _QUIET = 1, -8          # OpenCV's and ffmpeg's names for these
_log = logging.getLogger('replay.py')
Frames = Union[VideoFrames, 'BagFrames']


def main(painter: Painter, begin_s: float) -> int:
    """Do what the program's arguments say; return its exit code.

    begin_s: when the program began, by time.perf_counter.
    """
    logging.basicConfig(format='replay.py: %(levelname)s: %(message)s')
    logging.addLevelName(logging.WARNING, 'warning')        # as argparse has its error
    logging.addLevelName(logging.ERROR, 'error')
    # what they have to say is in the one line of ours
    cv2.setLogLevel(_FATAL)
    os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', str(_QUIET))
    interrupts = Interrupts()
    # roslaunch adds __name:=... and __log:=...
    arguments = [word for word in sys.argv[1:]
                 if not (word.startswith('__') and ':=' in word)]
    try:
        sys.stdout.write(replay(cli.parse(arguments), painter, begin_s, interrupts)
                         + '\n')
    except UserError as error:
        _log.error('%s', ' '.join(str(error).split()))
        return 1
    except OSError as error:
        _log.error('%s: %s', error.filename or 'cannot write', error.strerror or error)
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    return 0


def replay(options: argparse.Namespace, painter: Painter, begin_s: float,
           interrupts: Interrupts) -> str:
    """Do what the options say, and return what is to be said at the end.

    begin_s: when the program began, by time.perf_counter.
    interrupts: how a signal ends this.
    Raises UserError when it cannot be done; no file is written then.
    """
    frames = _frames(os.path.expanduser(options.input), options.topic)
    settings = _recognition(options.colors)
    paths = files.output_paths(os.path.expanduser(options.input),
                               os.path.expanduser(options.output), _EXTENSIONS)
    simulator = scenario.build(cli.world_of(options.world), os.path.expanduser(options.urdf),
                               cli.spawn_of(options))
    robot, odometry = simulator.vehicles[0].robot, simulator.vehicles[0].settings.odometry
    plot = PlotRecorder(settings.colors)
    with files.atomic_write(paths) as (bag_file, csv_file, png_file):
        bag = BagRecorder(bag_file.raw, settings.color_names, odometry,
                          odometry.base_frame or robot.root)
        text = io.TextIOWrapper(csv_file, 'utf-8', newline='')
        table = TableRecorder(text, settings.color_names)
        start_s = time.perf_counter()
        with interrupts.held():     # tqdm's destructor wants what its constructor makes
            progress = tqdm(prefetch(measured(frames, settings), _PREFETCHED), unit=' frames',
                            total=frames.expected or None, disable=None)
        with progress:
            end_ns = _run(Chain(simulator, settings, options.teleop, [bag, table, plot]),
                          progress, frames.period_ns)
        loop_s = time.perf_counter() - start_s
        painter.begin('Replay of {}, {} frames, in the world {}'.format(
            os.path.basename(options.input), plot.frames, os.path.basename(options.world)),
                      plot.numbers(end_ns / SECOND_NS, footprints(simulator.world)))
        bag.close()
        text.flush()
        png_file.write(painter.finish())
    for warning in frames.warnings:
        _log.warning('%s', warning)
    whole_s = time.perf_counter() - begin_s
    return _summary(plot.frames, end_ns / SECOND_NS, loop_s, whole_s, robot.motion(), paths)


def _run(chain: Chain, measured_frames: Iterable, period_ns: int) -> int:
    """Run the chain; return the time at its end."""
    end_ns = chain.run(measured_frames) + period_ns
    chain.end(end_ns)
    return end_ns


def _summary(frames: int, simulated_s: float, loop_s: float, whole_s: float, motion: Motion,
             paths) -> str:
    return ('{} frames, {:.3f} s simulated in {:.2f} s, {:.1f} times real time ({:.2f} s with '
            'world and plot); the robot ends at x {:.3f} m, y {:.3f} m, yaw {:.3f} rad; wrote {}'
            .format(frames, simulated_s, loop_s, simulated_s / loop_s, whole_s,
                    *motion.position[:2], motion.yaw, ', '.join(paths)))


def _frames(path: str, topic: str) -> Frames:
    if not os.path.isfile(path):
        raise UserError('cannot replay {}: {}; {}'.format(
            path, 'it is no file' if os.path.exists(path) else 'no such file',
            inputs.WANTED))
    if is_bag(path):
        # what only bags need takes a while to load
        from img_recog.replay.bags import BagFrames
        return BagFrames(path, topic)
    if topic:
        raise UserError('cannot replay {}: --topic is for a bag, and this is none'.format(path))
    return VideoFrames(path)


def _recognition(path: str) -> RecognitionSettings:
    if not path:
        return with_colors()()
    from img_recog.recognition import parameter_file  # takes a while to load
    return parameter_file.read(os.path.expanduser(path))
