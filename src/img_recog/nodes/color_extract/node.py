"""The node color_extract: colors in images to commands for a robot.

Subscribes: usb_cam/image_raw (sensor_msgs/Image, any encoding that cv_bridge turns into bgr8), or
in its place usb_cam/image_raw/compressed (sensor_msgs/CompressedImage).
Publishes, for every frame that it handles: blue_image, red_image (sensor_msgs/Image, bgr8, with
the frame's header: the frame with everything else black), then cmd_vel (geometry_msgs/Twist,
none, one or two: linear.x 10 m/s for blue, then -10 m/s for red); while somebody subscribes,
color_detection (sensor_msgs/PointCloud: areas and centroids) and color_overlay (sensor_msgs/Image,
bgr8: the frame with outlines and commands).
Reads: ~image_transport (raw or compressed: which of the two it subscribes to), ~colors_file (where
the parameters come from, to be checked), ~colors (names), ~NAME_image_topic for each color, and
RecognitionSettings with these colors, which are also served by dynamic_reconfigure:
~set_parameters, ~parameter_descriptions, ~parameter_updates.
"""
import threading
import time
from dataclasses import dataclass
from functools import partial
from typing import List, Sequence

import cv2
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import PointCloud

from img_recog.conversions import color_detection_msgs, twist_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.nodes import color_parameters
from img_recog.nodes.color_extract.inputs import INPUTS
from img_recog.recognition import overlay, parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command, Commander
from img_recog.ros import lifecycle, parameters
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.settings import Settings, one_of, setting

_CAMERA = 'usb_cam/image_raw'
_TOPICS = (_CAMERA, 'cmd_vel', 'color_detection', 'color_overlay', '/rosout')
_IDLE_S = 0.1           # how often what does not hang on frames is looked after


@dataclass(frozen=True)
class InputSettings(Settings):
    """How images come in, by the name that image_transport gives it, and a file to check.

    colors_file: where a launch file has loaded the parameters from. An empty file loads nothing,
    and roslaunch does not say so.
    """

    image_transport: str = setting('raw', one_of(*INPUTS))
    colors_file: str = setting('')


class ColorExtract:
    """Handles the newest frame; frames that arrive meanwhile replace each other."""

    def __init__(self):
        given = parameters.read(InputSettings)
        if given.colors_file:
            parameter_file.read(given.colors_file)
        settings = color_parameters.read()
        topics = color_parameters.read_image_topics(settings, _TOPICS)
        color_parameters.warn_of_unknown(settings, InputSettings)
        self._extractor = ColorExtractor(settings)
        self._commander = Commander(settings, time.monotonic())
        self._settings = settings
        self._warn = ThrottledWarning()
        self._velocity = DirectPublisher('cmd_vel', Twist)
        self._masked = [ImagePublisher(topic) for topic in topics]
        self._detection = rospy.Publisher('color_detection', PointCloud, queue_size=1)
        self._overlay = ImagePublisher('color_overlay')
        self._ended = threading.Event()
        self._handling = threading.Lock()
        lifecycle.on_shutdown(self._end)
        self._reconfigurable = Reconfigurable(settings, lambda _: None)
        self._input = INPUTS[given.image_transport](_CAMERA)

    def spin(self) -> None:
        """Handle frames until the node is shut down."""
        while not self._ended.is_set():
            msg = self._input.take(_IDLE_S)
            with self._handling:
                if self._ended.is_set():
                    return
                self._use(self._reconfigurable.settings)
                if msg is None:
                    self._send(self._commander.wait(time.monotonic()))
                else:
                    self.handle(msg)
                    self._input.done(msg)

    def handle(self, msg) -> None:
        """Recognize, publish and command."""
        try:
            image, encoding = self._input.decode(msg)
        except ImageError as error:
            self._warn('frame skipped: %s', error)
            return
        areas_px = self._extractor.measure(image, encoding)
        for number, publisher in enumerate(self._masked):
            publisher.publish_drawn(partial(self._extractor.masked, number),
                                    image.shape[:2] + (3,), 'bgr8', msg.header)
        rospy.loginfo(', '.join('{}={}'.format(name, area_px) for name, area_px
                                in zip(self._settings.color_names, areas_px)))
        commands = self._commander.decide(areas_px, time.monotonic())
        self._send(commands)
        self._describe(msg.header, areas_px, commands)

    def _describe(self, header, areas_px: Sequence[int], commands: Sequence[Command]) -> None:
        """Publish what others may want to know, after the command, which is in a hurry."""
        if self._detection.get_num_connections() > 0:
            centroids = [self._extractor.centroid(number) for number in range(len(areas_px))]
            self._detection.publish(color_detection_msgs.to_msg(
                self._settings.color_names, areas_px, centroids, header))
        if self._overlay.get_num_connections() > 0:
            image = overlay.draw(self._extractor, self._settings.colors, areas_px, commands)
            self._overlay.publish(image, 'bgr8', header)

    def _send(self, commands: List[Command]) -> None:
        for command in commands:
            self._velocity.publish(twist_msgs.to_msg(*command))

    def _use(self, settings) -> None:
        if settings is not self._settings:
            self._settings = settings
            self._extractor.configure(settings)
            self._commander.configure(settings)

    def _end(self) -> None:
        self._ended.set()
        with self._handling:        # nothing is sent after this
            self._send(self._commander.end())


def main() -> int:
    """Run the node; return its exit code."""
    # OpenCV's threads wait for work in a busy loop, which costs more than they help with
    cv2.setNumThreads(1)
    return lifecycle.run('color_extract', lambda: ColorExtract().spin())
