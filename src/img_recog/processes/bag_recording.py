"""Records topics to a bag by the distribution's `rosbag record`."""
import os
import re
import signal
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Callable, Optional, Sequence

from img_recog.camera_arguments import CAMERA_INFO_TOPIC, COMPRESSED_TOPIC
from img_recog.errors import UserError, one_line, shortened
from img_recog.processes import process_tree

# what is worth keeping of the whole system: no view and no masks, which can be made again
TOPICS = ('/clock', '/diagnostics', '/rosout_agg', '/tf', '/tf_static', 'cmd_vel',
          'color_detection', 'gazebo/world_outlines', 'imu', 'joint_states', 'odom', 'scan',
          CAMERA_INFO_TOPIC, COMPRESSED_TOPIC)
MAX_MEGABYTES = 2000
_START_TIMEOUT_S, _END_TIMEOUT_S, _POLL_PERIOD_S = 20.0, 10.0, 0.05
# of a line of roscpp: color, level and time
_PREFIX = re.compile(r'^(\x1b\[\d*m)*\[ *[A-Z]+\] \[[0-9.]+(, [0-9.]+)?\]: |\x1b\[\d*m')
_WARNING = re.compile(r'(\x1b\[\d*m)*\[ *WARN\]')
_ADVICE = 'start the demo in a folder where files can be written; is the disk full?'


class BagRecording:
    """A process that records. path: of the bag.

    It completes its file and ends when the thread that has started it ends, also by kill -9 of
    this process.
    """

    def __init__(self, path: str, topics: Sequence[str], max_megabytes: int = MAX_MEGABYTES,
                 is_ending: Callable[[], bool] = lambda: False):
        """Start to record.

        topics: resolved names; those that nobody publishes yet too. max_megabytes: it ends at
        this size. is_ending: returns whether the program ends, and does not wait. Raises UserError
        if it cannot be started, or cannot write the file.
        """
        self.path = path
        self._is_over = False           # its end is known
        self._errors = tempfile.TemporaryFile()
        try:
            # not `rosbag record`, which is a parent of this program and ends before it
            self._process = subprocess.Popen(
                ['setpriv', '--pdeathsig', 'INT', 'rosrun', 'rosbag', 'record', '--quiet',
                 '--lz4', '--size={}'.format(max_megabytes), '-O', path, *topics],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self._errors,
                start_new_session=True)         # Ctrl-C is for its parent, which stops it then
        except OSError as error:
            raise UserError('cannot record: setpriv: {}'.format(one_line(error)),
                            'install the package util-linux')
        end_s = time.monotonic() + _START_TIMEOUT_S
        while (self._is_starting() and time.monotonic() < end_s
               and not is_ending()):
            time.sleep(_POLL_PERIOD_S)
        self.check()
        if self._is_starting():
            self._end()
            raise UserError('cannot record {}: there is no file after {:g} s'.format(
                path, _START_TIMEOUT_S), 'see whether the master and the simulator run')

    @property
    def is_running(self) -> bool:
        """Whether it still records."""
        return self._process.poll() is None

    @property
    def _active(self) -> str:
        """The name of the file while it is written."""
        return self.path + '.active'

    def _is_starting(self) -> bool:
        """Return whether its header is not in the file yet; on a full disk, it never will be."""
        return self.is_running and not self._active_size()

    def _active_size(self) -> Optional[int]:
        """Return the size of the file in bytes while it is written; None: there is no file."""
        try:
            return os.path.getsize(self._active)
        except OSError:
            return None

    def check(self) -> bool:
        """Return whether it has ended by itself, at its largest size; True only once.

        Raises UserError if it has ended for another reason, also only once.
        """
        if self.is_running or self._is_over:
            return False
        self._is_over = True
        if self._process.returncode == 0:
            return True
        if self._active_size() == 0:
            os.unlink(self._active)
        problem = ('the recording {} has ended' if os.path.exists(self.path)
                   else 'cannot record {}').format(self.path)
        raise UserError('{}: {}'.format(problem, self._reason()), _ADVICE)

    def _reason(self) -> str:
        """Return the first line that it has printed, no warning; it may crash after that."""
        self._errors.seek(0)
        lines = [_PREFIX.sub('', line).strip()
                 for line in self._errors.read().decode(errors='replace').splitlines()
                 if not _WARNING.match(line)]
        return shortened(next(filter(None, lines), 'exit code {}'.format(
            self._process.returncode)))

    def stop(self) -> None:
        """End the recording, and wait until its file is complete.

        Raises UserError if there is no file then.
        """
        self._end()
        if not os.path.exists(self.path):
            raise UserError('the recording {} is not complete'.format(self.path), (
                'is the disk full? what there is has the suffix .active'
                if self._active_size() is not None else 'its file was removed'))

    def _end(self) -> None:
        self._is_over = True
        if self.is_running:
            self._process.send_signal(signal.SIGINT)
            process_tree.wait_or_kill(self._process, _END_TIMEOUT_S)


class RecordingSwitch:
    """Starts and stops recordings, one at a time. All methods may be called by any thread."""

    def __init__(self, start: Callable[[], BagRecording]):
        """start: begins a recording, or raises UserError."""
        self._start = start
        # one thread for all, as long as this process: a recording ends with its thread
        self._thread = ThreadPoolExecutor(1, 'recorder')
        self._recording: Optional[BagRecording] = None

    @property
    def path(self) -> str:
        """The path of the recording that runs; '' if there is none."""
        recording = self._recording
        return recording.path if recording is not None and recording.is_running else ''

    def record(self, is_wanted: bool) -> str:
        """Start or stop a recording if that is not done yet; return its path, '' if none.

        Waits until the file can be written, or is complete. Raises UserError if that fails.
        """
        return self._thread.submit(self._record, is_wanted).result()

    def _record(self, is_wanted: bool) -> str:
        recording = self._recording
        if recording is None or not recording.is_running:
            if not is_wanted:
                return ''
            self._recording = recording = self._start()
        elif not is_wanted:
            recording.stop()
        return recording.path

    def check(self) -> str:
        """Return the path of a recording that has ended at its largest size, only once.

        '' if there is none. Raises UserError if it has ended for another reason, also once.
        """
        recording = self._recording
        return recording.path if recording is not None and recording.check() else ''
