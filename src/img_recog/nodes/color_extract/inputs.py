"""Image inputs: the newest message of a topic with raw or compressed images."""
from typing import Any, Optional, Tuple

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.nodes.color_extract.diagnostics import RecognitionDiagnostics
from img_recog.ros import image_topics
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog.still_images import ImageTooLarge, check_size

_MAX_PIXEL_BYTES = 8        # of the encodings that cv_bridge converts to bgr8: bgra16
_MAX_OTHER_BYTES = 1 << 20  # of a message with an image: its header, the encoding


class _NewestInput:
    """Keeps the newest message of a topic, and counts the messages."""

    def __init__(self, counts: RecognitionDiagnostics, max_pixels: int):
        self._counts, self._max_pixels = counts, max_pixels
        self._latest = LatestValue()

    def _store(self, msg: Any) -> None:
        self._counts.received.add()
        replaced = self._latest.put(msg)
        if replaced is not None:
            self._counts.replaced.add()
            self.done(replaced)

    def take(self, timeout_s: float) -> Optional[Any]:
        """Return the newest message, None if there is none within the timeout or before `wake`."""
        return self._latest.take(timeout_s)

    def wake(self) -> None:
        """End the wait in `take` now."""
        self._latest.wake()

    def done(self, msg: Any) -> None:
        """Do nothing: the message has no reused buffer."""


class RawInput(_NewestInput):
    """Subscribes to raw images.

    max_pixels: larger images are refused.
    """

    def __init__(self, topic: str, counts: RecognitionDiagnostics, max_pixels: int):
        super().__init__(counts, max_pixels)
        self._images = image_msgs.ColorImages()
        self._subscriber = ImageSubscriber(
            topic, self._store, max_pixels * _MAX_PIXEL_BYTES + _MAX_OTHER_BYTES,
            counts.refused.add)

    def decode(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the image and its encoding, one of areas.ENCODINGS; it is valid until `done`.

        Raises ImageError naming the size, encoding and reason.
        """
        try:
            check_size(msg.width, msg.height, self._max_pixels)
        except ImageTooLarge as error:
            raise ImageError(str(error))
        return self._images.from_msg(msg)

    def done(self, msg: Image) -> None:
        """Release the buffer of a message, so that it can be reused."""
        self._subscriber.release(msg)


class CompressedInput(_NewestInput):
    """Subscribes to compressed images.

    topic: of the raw images; the compressed ones are on topic/compressed.
    max_pixels: larger images are refused before they are decoded.
    """

    def __init__(self, topic: str, counts: RecognitionDiagnostics, max_pixels: int):
        super().__init__(counts, max_pixels)
        rospy.Subscriber(image_topics.topic_beside(topic), CompressedImage, self._store,
                         queue_size=1, buff_size=1 << 24, tcp_nodelay=True)

    def decode(self, msg: CompressedImage) -> Tuple[np.ndarray, str]:
        """Return the image in bgr8, and its encoding.

        Raises ImageError naming format, size and reason.
        """
        return compressed_image_msgs.from_msg(msg, max_pixels=self._max_pixels), 'bgr8'


# by the name of the transport in image_transport
INPUTS = {'raw': RawInput, 'compressed': CompressedInput}
