"""Records a replay as a bag and as a table."""
import csv
import io
import os
from typing import IO, Optional, Sequence

import genpy
import rosbag
from tf2_msgs.msg import TFMessage

from img_recog.conversions import color_detection_msgs, robot_msgs, twist_msgs
from img_recog.replay.chain import SECOND_NS, CommandSent, FrameResult, Recorder
from img_recog.simulation.settings import OdometrySettings
from img_recog.simulation.vehicle import Reading

_BUFFER_BYTES = 1 << 18


class _AppendedFile(io.BufferedRandom):
    """A file whose `seek` to the end and `tell` there need no system call.

    rosbag calls both before each message, for which an ordinary file flushes its buffer and calls
    the kernel.
    """

    _end: Optional[int] = None      # position of the file if it is at its end

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        to_end = (offset, whence) == (0, os.SEEK_END)
        if to_end and self._end is not None:
            return self._end
        position = super().seek(offset, whence)
        self._end = position if to_end else None
        return position

    def tell(self) -> int:
        return super().tell() if self._end is None else self._end

    def write(self, data) -> int:
        count = super().write(data)
        if self._end is not None:
            self._end += count
        return count


class BagRecorder(Recorder):
    """Writes /cmd_vel, /color_detection, /joint_states, /odom and /tf to a bag.

    Detections have the stamps of the frames; other stamps are the stamp of the first frame plus
    simulated time.
    """

    def __init__(self, file: io.RawIOBase, names: Sequence[str], odometry: OdometrySettings,
                 base_frame: str):
        """Write to an open file, which is empty and unbuffered.

        names: of the colors; base_frame: child_frame_id of the odometry.
        """
        self._bag = rosbag.Bag(_AppendedFile(file, _BUFFER_BYTES), 'w')
        self._names, self._odometry, self._base_frame = names, odometry, base_frame
        self._start_ns = 0

    def start(self, stamp_ns: int) -> None:
        self._start_ns = stamp_ns

    def on_frame(self, result: FrameResult) -> None:
        self._write('/color_detection', color_detection_msgs.to_msg(
            self._names, result.areas_px, result.centroids, result.frame.header), result.time_ns)

    def on_command(self, sent: CommandSent) -> None:
        self._write('/cmd_vel', twist_msgs.to_msg(*sent.command), sent.time_ns)

    def on_reading(self, reading: Reading) -> None:
        time_ns = round(reading.time_s * SECOND_NS)
        stamp = _time(self._start_ns + time_ns)
        if reading.sensor == 'joint_states':
            msg = robot_msgs.joint_states_to_msg(reading.value, stamp)
            self._write('/joint_states', msg, time_ns)
        elif reading.sensor == 'odometry':
            msg = robot_msgs.odometry_to_msg(reading.value, self._odometry.odom_frame,
                                             self._base_frame, stamp)
            self._write('/odom', msg, time_ns)
            if self._odometry.publish_odom_tf:
                self._write('/tf', TFMessage([robot_msgs.transform_of(msg)]), time_ns)

    def close(self) -> None:
        """Write the index and close the file."""
        self._bag.close()

    def _write(self, topic: str, msg, time_ns: int) -> None:
        # the C++ tools of rosbag skip messages that were recorded at time 0
        self._bag.write(topic, msg, _time(max(1, self._start_ns + time_ns)))


class TableRecorder(Recorder):
    """Writes a CSV table: a header line, then a row for each frame.

    Several commands of a frame are in one field, separated by spaces. The pose in the world frame
    and the velocities of the robot's root link are those at the time of the frame.
    """

    def __init__(self, file: IO[str], names: Sequence[str]):
        """Write to an open file; names: of the colors."""
        self._rows = csv.writer(file, lineterminator='\n')
        self._rows.writerow([
            'time_s', 'frame', 'stamp_s', *(name + '_px' for name in names),
            'commands_linear_x_m_per_s', 'commands_angular_z_rad_per_s', 'x_m', 'y_m', 'yaw_rad',
            'linear_x_m_per_s', 'angular_z_rad_per_s'])

    def on_frame(self, result: FrameResult) -> None:
        motion = result.motion
        self._rows.writerow([
            _seconds(result.time_ns), result.frame.number, _seconds(result.frame.stamp_ns),
            *result.areas_px,
            ' '.join(str(command.linear_x) for command in result.commands),
            ' '.join(str(command.angular_z) for command in result.commands),
            *map(_number, (motion.position[0], motion.position[1], motion.yaw,
                           motion.linear[0], motion.angular[2]))])


def _time(time_ns: int) -> genpy.Time:
    return genpy.Time(*divmod(time_ns, SECOND_NS))


def _seconds(time_ns: int) -> str:
    return '{}.{:09d}'.format(*divmod(time_ns, SECOND_NS))


def _number(value: float) -> str:
    return '{:.6f}'.format(round(value, 6) + 0.0)       # + 0.0 turns -0.0 into 0.0
