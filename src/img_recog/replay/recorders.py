"""What a replay leaves behind as data: a bag and a table."""
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


class _Appended(io.BufferedRandom):
    """A file that is at its end, and goes there and knows where that is for nothing.

    rosbag asks it so before each message. An ordinary file then writes out its buffer, and asks
    the kernel.
    """

    _end: Optional[int] = None      # where the file is, if that is its end

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        to_end = (offset, whence) == (0, os.SEEK_END)
        if to_end and self._end is not None:
            return self._end
        position = super().seek(offset, whence)
        self._end = position if to_end else None
        return position

    def tell(self) -> int:
        return super().tell() if self._end is None else self._end

    def write(self, data: bytes) -> int:
        count = super().write(data)
        if self._end is not None:
            self._end += count
        return count


class BagRecorder(Recorder):
    """Writes /cmd_vel, /color_detection, /joint_states, /odom and /tf.

    Stamps are those of the frames, and for the rest simulated time from the first frame on.
    """

    def __init__(self, file: io.RawIOBase, names: Sequence[str], odometry: OdometrySettings,
                 base_frame: str):
        """Write to an open file, empty and without a buffer.

        names: of the colors. base_frame: child_frame_id of the odometry.
        """
        self._bag = rosbag.Bag(_Appended(file, _BUFFER_BYTES), 'w')
        self._names, self._odometry, self._base_frame = names, odometry, base_frame
        self._start_ns = 0

    def start(self, stamp_ns: int) -> None:
        self._start_ns = stamp_ns

    def on_frame(self, seen: FrameResult) -> None:
        self._write('/color_detection', color_detection_msgs.to_msg(
            self._names, seen.areas_px, seen.centroids, seen.frame.header), seen.time_ns)

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
        # rosbag's tools in C++ leave out what was recorded at time 0
        self._bag.write(topic, msg, _time(max(1, self._start_ns + time_ns)))


class TableRecorder(Recorder):
    """Writes CSV: a header line, then a row for each frame.

    Several commands for a frame are in one field, a space between. Pose in the world and
    velocities in the robot's root link are those when the frame came.
    """

    def __init__(self, file: IO[str], names: Sequence[str]):
        """Write to an open file; names: of the colors."""
        self._rows = csv.writer(file, lineterminator='\n')
        self._rows.writerow([
            'time_s', 'frame', 'stamp_s', *(name + '_px' for name in names),
            'commands_linear_x_m_per_s', 'commands_angular_z_rad_per_s', 'x_m', 'y_m', 'yaw_rad',
            'linear_x_m_per_s', 'angular_z_rad_per_s'])

    def on_frame(self, seen: FrameResult) -> None:
        motion = seen.motion
        self._rows.writerow([
            _seconds(seen.time_ns), seen.frame.number, _seconds(seen.frame.stamp_ns),
            *seen.areas_px,
            ' '.join(str(command.linear_x) for command in seen.commands),
            ' '.join(str(command.angular_z) for command in seen.commands),
            *map(_number, (motion.position[0], motion.position[1], motion.yaw,
                           motion.linear[0], motion.angular[2]))])


def _time(time_ns: int) -> genpy.Time:
    return genpy.Time(*divmod(time_ns, SECOND_NS))


def _seconds(time_ns: int) -> str:
    return '{}.{:09d}'.format(*divmod(time_ns, SECOND_NS))


def _number(value: float) -> str:
    return '{:.6f}'.format(round(value, 6) + 0.0)       # no minus before a zero
