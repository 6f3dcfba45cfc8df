"""How images come in: raw or compressed, and of them the newest."""
from typing import Optional, Tuple

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.ros import image_topics
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport.image_subscriber import ImageSubscriber


class RawInput:
    """The newest image of a topic of raw images."""

    def __init__(self, topic: str):
        self._newest, self._images = LatestValue(), image_msgs.ColorImages()
        self._subscriber = ImageSubscriber(topic, self._keep)

    def _keep(self, msg: Image) -> None:
        replaced = self._newest.put(msg)
        if replaced is not None:
            self._subscriber.release(replaced)

    def take(self, timeout_s: float) -> Optional[Image]:
        """Return the newest message, None when there is none in time."""
        return self._newest.take(timeout_s)

    def decode(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the image and its encoding, as ColorImages does: until `done`.

        Raises ImageError naming the size, encoding and reason.
        """
        return self._images.from_msg(msg)

    def done(self, msg: Image) -> None:
        """Give the memory of a message back."""
        self._subscriber.release(msg)


class CompressedInput:
    """The newest image of the topic of compressed images beside one of raw images."""

    def __init__(self, topic: str):
        self._newest = LatestValue()
        rospy.Subscriber(image_topics.topic_beside(topic), CompressedImage, self._newest.put,
                         queue_size=1, buff_size=1 << 24, tcp_nodelay=True)

    def take(self, timeout_s: float) -> Optional[CompressedImage]:
        """Return the newest message, None when there is none in time."""
        return self._newest.take(timeout_s)

    def decode(self, msg: CompressedImage) -> Tuple[np.ndarray, str]:
        """Return the image, bgr8, and its encoding.

        Raises ImageError naming format, size and reason.
        """
        return compressed_image_msgs.from_msg(msg), 'bgr8'

    def done(self, msg: CompressedImage) -> None:
        """Nothing is kept."""


# by the name that image_transport gives them
INPUTS = {'raw': RawInput, 'compressed': CompressedInput}
