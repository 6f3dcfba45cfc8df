"""The chain from a known image to the robot's motion, checked from outside of the nodes."""
import select
import time
from typing import Dict, List, NamedTuple, Optional, Tuple

import cv2
import numpy as np
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from tf2_msgs.msg import TFMessage

from img_recog_helpers import wire

RATE_HZ = 30
PHASE_S = 0.6                               # of wall time: how long the film shows a color
SPEED = 0.2                                 # m/s, the command for blue; red is backward
COMMANDS = {'blue': SPEED, 'red': -SPEED}
_PIXELS = {'blue': (255, 0, 0), 'red': (85, 0, 255), 'nothing': (90, 90, 90)}       # bgr
_SIZE = (120, 160)
_MOVING, _STANDING = 0.02, 0.01             # m/s
_POLL_MS = 20

# the parameters of color_extract in a demo under test
COLORS = 'blue_linear_x: {}\nred_linear_x: {}\n'.format(SPEED, -SPEED)


def frame(color: str) -> np.ndarray:
    """Return a bgr8 image that shows one color, or nothing."""
    return np.full(_SIZE + (3,), _PIXELS[color], np.uint8)


def message(color: str) -> Image:
    """Return such an image as a message."""
    height, width = _SIZE
    return Image(height=height, width=width, encoding='bgr8', step=width * 3,
                 data=frame(color).tobytes())


def write_film(path: str) -> None:
    """Write a video that shows blue, red and nothing in turn."""
    video = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), RATE_HZ, _SIZE[::-1])
    for color in _PIXELS:
        for _ in range(round(PHASE_S * RATE_HZ)):
            video.write(frame(color))
    video.release()


def color_of(msg: Image) -> Optional[str]:
    """Return which color an rgb8 image of the film shows; None for the first of a new one."""
    middle = msg.height // 2 * msg.step + msg.width // 2 * 3
    pixel = np.array(list(msg.data[middle:middle + 3])[::-1], int)
    for color, expected in _PIXELS.items():
        if len(pixel) == 3 and np.abs(pixel - expected).max() < 40:
            return color
    return None


class Stream(NamedTuple):
    """A topic of a node that has to be published."""

    topic: str
    node: str
    data_class: type


CAMERA = Stream('/usb_cam/image_raw', '/usb_cam', Image)
COMMAND = Stream('/cmd_vel', '/color_extract', Twist)
TELEOP = Stream('/cmd_vel', '/turtlebot3_teleop_keyboard', Twist)
ODOMETRY = Stream('/odom', '/gazebo', Odometry)
JOINTS = Stream('/tf', '/robot_state_publisher', TFMessage)
DEMO = (CAMERA, COMMAND, TELEOP, ODOMETRY, JOINTS)
RECOGNITION = (CAMERA, COMMAND)


class ChainError(AssertionError):
    """The chain does not work."""


class Result(NamedTuple):
    """Seconds until the chain worked (each part, and one color) and until each color was seen.

    They include the time until the film shows the next color.
    """

    recovered_s: float
    complete_s: float


class Chain:
    """Subscribes anew for each check, like a user who looks whether everything works.

    The film shows a color; its command must follow, then the motion of the robot. The robot
    stands when the film shows nothing.
    """

    def __init__(self, master: str, streams: Tuple[Stream, ...] = DEMO):
        self._master, self._streams = master, streams
        self._open: Dict[Stream, wire.Subscription] = {}
        self._begin()

    def _begin(self) -> None:
        self._arrived: Dict[Stream, int] = dict.fromkeys(self._streams, 0)
        self._reasons: Dict[Stream, str] = {}
        self._color: Optional[str] = None
        # the robot may still move by a command of before: the first color proves nothing
        self._is_first_color = True
        self._is_commanded = False
        self._proven: Dict[str, float] = {}

    def wait(self, limit_s: float, all_colors: bool = True) -> Result:
        """Wait until the whole chain works; raise ChainError after the limit.

        limit_s: for one color; the other colors have two turns of the film more.
        all_colors: whether to wait for them.
        """
        self._begin()
        start = time.monotonic()
        recovered_s = None
        try:
            while True:
                now_s = time.monotonic() - start
                if recovered_s is None and self._works():
                    recovered_s = now_s
                if recovered_s is not None and (
                        not all_colors or len(self._proven) >= len(self._expected())):
                    return Result(recovered_s, now_s)
                if now_s > limit_s + (0 if recovered_s is None else 6 * PHASE_S + limit_s):
                    raise ChainError('not within {:.1f} s: {}'.format(limit_s, self._state()))
                self._connect()
                self._receive()
        finally:
            self.close()

    def close(self) -> None:
        """Close all subscriptions."""
        while self._open:
            self._open.popitem()[1].close()

    def _expected(self) -> List[str]:
        return list(_PIXELS) if ODOMETRY in self._streams else list(COMMANDS)

    def _works(self) -> bool:
        return all(self._arrived.values()) and bool(set(self._proven) & set(COMMANDS))

    def _state(self) -> str:
        missing = ['{} of {} ({})'.format(each.topic, each.node, self._reasons.get(
            each, 'no message')) for each, count in self._arrived.items() if not count]
        missing += ['the reaction to ' + color for color in self._expected()
                    if color not in self._proven]
        return 'missing: {}; frames show {}, commanded: {}'.format(
            ', '.join(missing), self._color, self._is_commanded)

    def _connect(self) -> None:
        for stream in self._streams:
            if stream in self._open:
                continue
            try:
                self._open[stream] = wire.Subscription(
                    self._master, stream.node, stream.topic, stream.data_class, 1.0)
            except wire.ERRORS as error:
                self._reasons[stream] = str(error)

    def _receive(self) -> None:
        poll = select.poll()
        streams = {}
        for stream, subscription in self._open.items():
            poll.register(subscription.sock, select.POLLIN)
            streams[subscription.sock.fileno()] = stream
        if not streams:
            time.sleep(_POLL_MS / 1000)
        # in the order of the chain, so that a command is not taken before its image
        ready = {descriptor for descriptor, _ in poll.poll(_POLL_MS)}
        for stream in sorted((streams[each] for each in ready), key=self._streams.index):
            try:
                messages = self._open[stream].read()
            except wire.ERRORS as error:
                self._reasons[stream] = str(error)
                self._open.pop(stream).close()
                continue
            self._arrived[stream] += len(messages)
            for msg in messages:
                self._take(stream, msg)

    def _take(self, stream: Stream, msg) -> None:
        if stream is CAMERA:
            color = color_of(msg)
            if color != self._color:
                self._is_first_color = self._color is None
                self._color, self._is_commanded = color, color == 'nothing'
        elif stream is COMMAND:
            expected = COMMANDS.get(self._color or '')
            if expected is not None and msg.linear.x == expected:
                self._is_commanded = True
                if ODOMETRY not in self._streams:
                    self._prove()
        elif stream is ODOMETRY and self._is_commanded and not self._is_first_color:
            speed = msg.twist.twist.linear.x * np.sign(COMMANDS.get(self._color or '', 0.0))
            if speed > _MOVING or self._color == 'nothing' and \
                    abs(msg.twist.twist.linear.x) < _STANDING:
                self._prove()

    def _prove(self) -> None:
        self._proven.setdefault(self._color or '', time.monotonic())
