"""Frames and a recorder for the tests of replays, and what they write."""
import numpy as np
import rospy
from std_msgs.msg import Header

from img_recog.replay.chain import Frame, Recorder

# bgr8 of the article's blue and red
BLUE, RED, GREY = (255, 0, 0), (128, 0, 255), (90, 90, 90)


def image(*colors, width=40):
    """Return a grey bgr8 image of 200x40 with stripes of width x 40 pixels in these colors."""
    result = np.full((40, 200, 3), GREY, np.uint8)
    for number, color in enumerate(colors):
        result[:, number * width:(number + 1) * width] = color
    return result


def frame(number, stamp_ns, *colors):
    """Return a Frame with stripes in these colors."""
    header = Header(number, rospy.Time(*divmod(stamp_ns, 10 ** 9)), 'head_camera')
    return Frame(number, stamp_ns, header, image(*colors), 'bgr8')


def contents(folder, part='.replay.'):
    """Return the contents of the files in a folder whose names have this part, in order."""
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())
            if part in path.name}


class EventLog(Recorder):
    """Collects all events."""

    def __init__(self):
        self.start_ns, self.frames, self.commands, self.readings = None, [], [], []

    def start(self, stamp_ns):
        self.start_ns = stamp_ns

    def on_frame(self, result):
        self.frames.append(result)

    def on_command(self, sent):
        self.commands.append((sent.time_ns, sent.command.linear_x, sent.sender))

    def on_reading(self, reading):
        self.readings.append(reading)
