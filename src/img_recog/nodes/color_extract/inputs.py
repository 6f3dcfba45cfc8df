"""Image inputs: the newest message of a topic with raw or compressed images."""
from typing import Optional, Tuple

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.ros import image_topics
from img_recog.ros.diagnostics import Counter
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport.image_subscriber import ImageSubscriber


class RawInput:
    """Subscribes to raw images and keeps the newest.

    received, replaced: counters of the images that arrived, and of those that were not taken.
    A raw image is never larger than its message, so that it needs no limit.
    """

    def __init__(self, topic: str, received: Counter, replaced: Counter, _max_pixels: int):
        self._received, self._replaced = received, replaced
        self._latest, self._images = LatestValue(), image_msgs.ColorImages()
        self._subscriber = ImageSubscriber(topic, self._store)

    def _store(self, msg: Image) -> None:
        self._received.add()
        replaced = self._latest.put(msg)
        if replaced is not None:
            self._replaced.add()
            self._subscriber.release(replaced)

    def take(self, timeout_s: float) -> Optional[Image]:
        """Return the newest message, None if there is none within the timeout or before `wake`."""
        return self._latest.take(timeout_s)

    def wake(self) -> None:
        """End the wait in `take` now."""
        self._latest.wake()

    def decode(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the image and its encoding, one of areas.ENCODINGS; it is valid until `done`.

        Raises ImageError naming the size, encoding and reason.
        """
        return self._images.from_msg(msg)

    def done(self, msg: Image) -> None:
        """Release the buffer of a message, so that it can be reused."""
        self._subscriber.release(msg)


class CompressedInput:
    """Subscribes to compressed images and keeps the newest.

    topic: of the raw images; the compressed ones are on topic/compressed.
    received, replaced: as of RawInput.
    max_pixels: larger images are refused before they are decoded.
    """

    def __init__(self, topic: str, received: Counter, replaced: Counter, max_pixels: int):
        self._received, self._replaced, self._max_pixels = received, replaced, max_pixels
        self._latest = LatestValue()
        rospy.Subscriber(image_topics.topic_beside(topic), CompressedImage, self._store,
                         queue_size=1, buff_size=1 << 24, tcp_nodelay=True)

    def _store(self, msg: CompressedImage) -> None:
        self._received.add()
        if self._latest.put(msg) is not None:
            self._replaced.add()

    def take(self, timeout_s: float) -> Optional[CompressedImage]:
        """Return the newest message, None if there is none within the timeout or before `wake`."""
        return self._latest.take(timeout_s)

    def wake(self) -> None:
        """End the wait in `take` now."""
        self._latest.wake()

    def decode(self, msg: CompressedImage) -> Tuple[np.ndarray, str]:
        """Return the image in bgr8, and its encoding.

        Raises ImageError naming format, size and reason.
        """
        return compressed_image_msgs.from_msg(msg, max_pixels=self._max_pixels), 'bgr8'

    def done(self, msg: CompressedImage) -> None:
        """Do nothing: the message has no reused buffer."""


# by the name of the transport in image_transport
INPUTS = {'raw': RawInput, 'compressed': CompressedInput}
