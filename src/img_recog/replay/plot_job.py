"""The program plot: draws a drive, of a bag or of the running system, as replay.py does."""
import argparse
import contextlib
import logging
import os
import tempfile
import time
from typing import Iterator, List, Optional, Sequence

import rosgraph
from tqdm import tqdm

from img_recog import files
from img_recog.command_line import programs
from img_recog.command_line.option_types import allowed
from img_recog.errors import UserError, counted, one_line, shortened
from img_recog.processes.bag_recording import BagRecording
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings.bag_file import open_bag
from img_recog.replay import figure
from img_recog.replay.recorded_drive import drive_of, odometry_of, topics_beside
from img_recog.ros import timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master

_SECONDS, _MAX_SECONDS = 20.0, 86400.0
_TICK_S, _TIMEOUT_S = 0.2, 3.0
_NODE = '/img_recog_plot'
_BAG_ADVICE = 'give a bag, as of ./run demo record:=FILE, or none to record the running system'
_MASTER_ADVICE = 'start the demo first, or set ROS_MASTER_URI; or give a bag'
_ERRORS = (*timed_xmlrpc.ERRORS, ValueError, TypeError)
_log = logging.getLogger('plot.py')


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
