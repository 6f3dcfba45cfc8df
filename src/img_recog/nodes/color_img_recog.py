"""The node color_extract: colours in images to commands for a robot.

Subscribes: usb_cam/image_raw (sensor_msgs/Image, any encoding that cv_bridge turns into bgr8), or
in its place usb_cam/image_raw/compressed (sensor_msgs/CompressedImage).
Publishes, for every frame that it handles: blue_image, red_image (sensor_msgs/Image, bgr8, with
the frame's header: the frame with everything else black), then cmd_vel (geometry_msgs/Twist,
none, one or two: linear.x 10 m/s for blue, then -10 m/s for red).
Reads: ~image_transport (raw or compressed, default raw): which of the two it subscribes to.
"""
from dataclasses import dataclass

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import CompressedImage, Image

from img_recog.nodes import (compressed_image_msgs, compressed_images, image_msgs, parameters,
                             running, twist_msgs)
from img_recog.nodes.slots import Newest
from img_recog.nodes.throttle import ThrottledWarning
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import commands
from img_recog.recognition.settings import with_colors
from img_recog.settings import Settings, one_of, setting

_CAMERA = 'usb_cam/image_raw'
# bytes read from the socket at a time: more than any image, or rospy falls behind on large ones
_BUFFER_BYTES = 1 << 26


@dataclass(frozen=True)
class TransportSettings(Settings):
    """How images come in, by the name that image_transport gives it."""

    image_transport: str = setting('raw', one_of('raw', 'compressed'))


class ColorExtract:
    """Handles the newest frame; frames that arrive meanwhile replace each other."""

    def __init__(self):
        compressed = parameters.read(TransportSettings).image_transport == 'compressed'
        parameters.warn_of_unknown(TransportSettings)
        self._frames = Newest()
        self._warn = ThrottledWarning()
        self._velocity = rospy.Publisher('cmd_vel', Twist, queue_size=10)
        self._settings = with_colors()()
        self._extractor = ColorExtractor(self._settings)
        self._images = [rospy.Publisher(color.name + '_image', Image, queue_size=1)
                        for color in self._settings.colors]
        if compressed:
            self._decode = compressed_image_msgs.from_msg
            topic, kind = compressed_images.topic_beside(_CAMERA), CompressedImage
        else:
            self._decode, topic, kind = image_msgs.from_msg, _CAMERA, Image
        rospy.Subscriber(topic, kind, self._frames.put, queue_size=1, buff_size=_BUFFER_BYTES,
                         tcp_nodelay=True)

    def spin(self) -> None:
        """Handle frames until the node is shut down."""
        while not rospy.is_shutdown():
            msg = self._frames.take(timeout_s=0.1)
            if msg is not None:
                self._handle(msg)

    def _handle(self, msg) -> None:
        try:
            image = self._decode(msg, 'bgr8')
        except image_msgs.ImageError as error:
            self._warn('frame skipped: %s', error)
            return
        areas_px = self._extractor.measure(image)
        for number, publisher in enumerate(self._images):
            publisher.publish(
                image_msgs.to_msg(self._extractor.masked(number), 'bgr8', msg.header))
        rospy.loginfo(', '.join('{}={}'.format(color.name, area_px) for color, area_px
                                in zip(self._settings.colors, areas_px)))
        for command in commands(areas_px, self._settings):
            self._velocity.publish(twist_msgs.to_msg(*command))


def main() -> int:
    """Run the node; return its exit code."""
    return running.run('color_extract', lambda: ColorExtract().spin())
