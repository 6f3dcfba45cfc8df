"""Image inputs: the newest message of a topic with raw or compressed images."""
import time
from typing import Any, Callable, Iterable, Optional, Tuple, Union

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.nodes.color_extract.diagnostics import RecognitionDiagnostics
from img_recog.ros import image_topics
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport import image_subscriber
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog.still_images import ImageTooLarge, check_size

TRANSPORTS = ('raw', 'compressed')      # names as in image_transport
_MAX_PIXEL_BYTES = 8        # of the encodings that cv_bridge converts to bgr8: bgra16
_MAX_OTHER_BYTES = 1 << 20  # of a message with an image: its header, the encoding
# Processing is too slow for the thread that receives if an image takes longer, or if more wait in
# its socket; it is left to the loop for this time.
_MAX_PROCESSING_S, _MAX_WAITING = 0.03, 1
_LATE_S = 1.0


class _NewestInput:
    """Keeps the newest message of a topic for a loop, and counts the messages."""

    def __init__(self, counts: RecognitionDiagnostics, max_pixels: int):
        self._counts, self._max_pixels = counts, max_pixels
        self._latest = LatestValue()

    def _store(self, msg: Any) -> None:
        self._counts.received.add()
        self._keep(msg)

    def _keep(self, msg: Any) -> bool:
        """Leave a message to the loop; return whether it had not taken the one before."""
        replaced = self._latest.put(msg)
        if replaced is not None:
            self._counts.replaced.add()
            self.done(replaced)
        return replaced is not None

    def take(self, timeout_s: float) -> Optional[Any]:
        """Return the newest message, None if there is none within the timeout or before `wake`."""
        return self._latest.take(timeout_s)

    def wake(self) -> None:
        """End the wait in `take` now."""
        self._latest.wake()

    def done(self, msg: Any) -> None:
        """Do nothing: the message has no reused buffer."""

    def took(self, seconds: float) -> None:
        """Do nothing: the loop does not change."""


class RawInput(_NewestInput):
    """Subscribes to raw images.

    An image is processed in the thread that receives it, in part while it arrives: this saves
    the change to another thread. When that takes too long for the rate of the images, it is left
    to the loop for a while, so that images are received meanwhile and the loop gets the newest.
    """

    def __init__(self, topic: str, counts: RecognitionDiagnostics, max_pixels: int,
                 begin: Callable[[Image], Iterable[int]], process: Callable[[Image], bool],
                 now: Callable[[], float] = time.monotonic):
        """Subscribe to the topic.

        max_pixels: larger images are refused.
        begin: as for ImageSubscriber.
        process: is called with a complete image, in any thread; returns whether it was processed.
        If it was not, the image is left to the loop.
        """
        super().__init__(counts, max_pixels)
        self._begin, self._process, self._now = begin, process, now
        self._late_until_s = now()
        self._images = image_msgs.ColorImages()
        self._subscriber = ImageSubscriber(
            topic, self._store, max_pixels * _MAX_PIXEL_BYTES + _MAX_OTHER_BYTES,
            counts.refused.add, self._work_ahead)

    def view(self, msg: Image) -> Optional[np.ndarray]:
        """Return the image of a message that is not complete yet; None if `decode` is needed.

        Raises ImageError like `decode`.
        """
        self._check_size(msg)
        return image_msgs.color_view(msg)

    def decode(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the image and its encoding, one of areas.ENCODINGS; it is valid until `done`.

        Raises ImageError naming the size, encoding and reason.
        """
        self._check_size(msg)
        return self._images.from_msg(msg)

    def done(self, msg: Image) -> None:
        """Release the buffer of a message, so that it can be reused."""
        self._subscriber.release(msg)

    def took(self, seconds: float) -> None:
        """Take note of how long it took to process an image."""
        if seconds > _MAX_PROCESSING_S:
            self._be_late()

    def _check_size(self, msg: Image) -> None:
        try:
            check_size(msg.width, msg.height, self._max_pixels)
        except ImageTooLarge as error:
            raise ImageError(str(error))

    def _work_ahead(self, msg: Image) -> Iterable[int]:
        return () if self._is_late() else self._begin(msg)

    def _store(self, msg: Image) -> None:
        self._counts.received.add()
        if image_subscriber.backlog(msg) > _MAX_WAITING:
            self._be_late()
        if self._is_late() or not self._process(msg):
            if self._keep(msg):
                self._be_late()

    def _is_late(self) -> bool:
        return self._now() < self._late_until_s

    def _be_late(self) -> None:
        self._late_until_s = self._now() + _LATE_S


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


def subscribe(transport: str, topic: str, counts: RecognitionDiagnostics, max_pixels: int,
              begin: Callable[[Image], Iterable[int]], process: Callable[[Image], bool]
              ) -> Union[RawInput, CompressedInput]:
    """Return the input for a transport, one of TRANSPORTS; the other arguments are RawInput's."""
    if transport == 'compressed':       # decoding takes long: always left to the loop
        return CompressedInput(topic, counts, max_pixels)
    return RawInput(topic, counts, max_pixels, begin, process)
