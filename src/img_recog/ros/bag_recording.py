"""Records topics to a bag by the distribution's `rosbag record`."""
import os
import signal
import subprocess
from typing import Sequence

from img_recog.errors import UserError, one_line

# what is worth keeping of the whole system: no view and no masks, which can be made again
TOPICS = ('clock', 'cmd_vel', 'color_detection', 'diagnostics', 'gazebo/world_outlines', 'imu',
          'joint_states', 'odom', 'rosout_agg', 'scan', 'tf', 'tf_static', 'usb_cam/camera_info',
          'usb_cam/image_raw/compressed')
MAX_MEGABYTES = 2000
_END_TIMEOUT_S = 10.0


class BagRecording:
    """A process that records. path: of the bag."""

    def __init__(self, path: str, topics: Sequence[str], max_megabytes: int = MAX_MEGABYTES):
        """Start to record.

        topics: resolved names; those that nobody publishes yet too. max_megabytes: it ends at
        this size. Raises UserError if it cannot be started.
        """
        self.path = path
        try:
            self._process = subprocess.Popen(
                ['rosbag', 'record', '--quiet', '--lz4', '--size={}'.format(max_megabytes),
                 '-O', path, *topics], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL)
        except OSError as error:
            raise UserError('cannot record: rosbag: {}'.format(one_line(error)),
                            'install the package rosbag')

    @property
    def is_running(self) -> bool:
        """Whether it still records."""
        return self._process.poll() is None

    def stop(self) -> None:
        """End the recording, and wait until its file is complete.

        Raises UserError if there is no file then.
        """
        if self.is_running:
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(_END_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if not os.path.exists(self.path):
            raise UserError('the recording {} is not complete'.format(self.path),
                            'is the disk full? what there is has the suffix .active')
