"""Records a replay: as a bag, as a table, and as the data of the picture."""
from typing import IO, Any, List, Mapping, Sequence

import genpy
import numpy as np
import rosbag
from tf2_msgs.msg import TFMessage

from img_recog.conversions import color_detection_msgs, robot_msgs, twist_msgs
from img_recog.conversions.sensor_table import SENSORS
from img_recog.recognition.recognition_settings import Color
from img_recog.replay.chain import (RECOGNITION, SECOND_NS, TELEOP, CommandSent, FrameResult,
                                    Recorder)
from img_recog.replay.plot_data import SPEED, TURN, PlotData, Rows
from img_recog.simulation.simulated_model import Reading

RECORDED = 'odometry', 'joint_states'       # of the sensors
_KINDS = {kind.name: kind for kind in SENSORS}


class BagRecorder(Recorder):
    """Writes /cmd_vel, /color_detection, /joint_states, /odom and /tf to a bag.

    Detections have the stamps of the frames; other stamps are the stamp of the first frame plus
    simulated time.
    """

    def __init__(self, file: IO[bytes], names: Sequence[str], sensors: Mapping[str, Any]):
        """Write to an open, empty file.

        names: of the colors; sensors: the settings of a robot's sensors.
        """
        self._bag = rosbag.Bag(file, 'w')
        self._names, self._sensors = names, sensors
        self._start_ns = 0

    def start(self, stamp_ns: int) -> None:
        self._start_ns = stamp_ns

    def on_frame(self, result: FrameResult) -> None:
        if self._names:
            self._write('/color_detection', color_detection_msgs.to_msg(
                self._names, result.areas_px, result.centroids, result.frame.header),
                        result.time_ns)

    def on_command(self, sent: CommandSent) -> None:
        self._write('/cmd_vel', twist_msgs.to_msg(*sent.command), sent.time_ns)

    def on_reading(self, reading: Reading) -> None:
        if reading.sensor not in RECORDED:
            return
        time_ns = round(reading.time_s * SECOND_NS)
        kind, settings = _KINDS[reading.sensor], self._sensors[reading.sensor]
        msg = kind.to_msg(reading.value, settings, _time(self._start_ns + time_ns))
        self._write('/' + kind.topic(kind.settings()), msg, time_ns)
        if reading.sensor == 'odometry' and settings.publish_odom_tf:
            self._write('/tf', TFMessage([robot_msgs.transform_of(msg)]), time_ns)

    def close(self) -> None:
        """Write the index and close the file."""
        self._bag.close()

    def _write(self, topic: str, msg, time_ns: int) -> None:
        # the C++ tools of rosbag skip messages that were recorded at time 0
        self._bag.write(topic, msg, _time(max(1, self._start_ns + time_ns)))
        # what rosbag keeps of each message is to read it again, and is not in the file
        self._bag._connection_indexes.clear()


class TableRecorder(Recorder):
    """Writes a CSV table: a header line, then a row for each frame.

    Several commands of a frame are in one field, separated by spaces. The pose in the world frame
    and the velocities of the robot's root link are those at the time of the frame.
    """

    def __init__(self, rows: Any):
        """rows: a csv.writer for the rows below the `head`."""
        self._rows = rows

    @staticmethod
    def head(names: Sequence[str]) -> List[str]:
        """Return the names of the columns; names: of the colors."""
        return ['time_s', 'frame', 'stamp_s', *(name + '_px' for name in names),
                'commands_linear_x_m_per_s', 'commands_angular_z_rad_per_s', 'x_m', 'y_m',
                'yaw_rad', 'linear_x_m_per_s', 'angular_z_rad_per_s']

    def on_frame(self, result: FrameResult) -> None:
        motion = result.motion
        self._rows.writerow([
            seconds_text(result.time_ns), result.frame.number, seconds_text(result.frame.stamp_ns),
            *result.areas_px,
            ' '.join(str(command.linear_x) for command in result.commands),
            ' '.join(str(command.angular_z) for command in result.commands),
            *map(_number, (motion.position[0], motion.position[1], motion.yaw,
                           motion.linear[0], motion.angular[2]))])


class PlotRecorder(Recorder):
    """Collects the data that is drawn at the end of a replay.

    frames: number of frames so far.
    """

    def __init__(self, colors: Sequence[Color]):
        self._colors = colors
        self.frames = 0
        # the places of the robot stay together, so that they are on its path
        self._motion, self._areas = Rows(TURN + 1, SPEED), Rows(1 + len(colors), 1)
        self._sent = {sender: Rows(3, 1) for sender in (RECOGNITION, TELEOP)}

    def on_frame(self, result: FrameResult) -> None:
        motion, time_s = result.motion, result.time_ns / SECOND_NS
        self.frames += 1
        self._motion.add((time_s, motion.position[0], motion.position[1], motion.yaw,
                          motion.linear[0], motion.angular[2]))
        self._areas.add((time_s, *result.areas_px))

    def on_command(self, sent: CommandSent) -> None:
        self._sent[sent.sender].add((sent.time_ns / SECOND_NS, *sent.command[:2]))

    def data(self, end_s: float, outlines: Sequence[np.ndarray]) -> PlotData:
        """Return the collected data; end_s, outlines: as in PlotData."""
        return PlotData(self._colors, self._motion.array(), self._areas.array(),
                        self._sent[RECOGNITION].array(), self._sent[TELEOP].array(), end_s,
                        outlines)


def _time(time_ns: int) -> genpy.Time:
    return genpy.Time(*divmod(time_ns, SECOND_NS))


def seconds_text(time_ns: int) -> str:
    """Return a time in s with all of its digits.

    >>> seconds_text(1600000000040000123)
    '1600000000.040000123'
    """
    return '{}.{:09d}'.format(*divmod(time_ns, SECOND_NS))


def _number(value: float) -> str:
    return '{:.6f}'.format(round(value, 6) + 0.0)       # + 0.0 turns -0.0 into 0.0
