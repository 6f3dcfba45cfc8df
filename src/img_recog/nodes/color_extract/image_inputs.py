"""Image inputs: the newest message of a topic with raw or compressed images."""
import time
from typing import Callable, Tuple, Union

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs
from img_recog.conversions.image_msgs import ColorImages
from img_recog.nodes.color_extract.recognition_diagnostics import RecognitionDiagnostics
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport.image_subscriber import ImageSubscriber

TRANSPORTS = ('raw', 'compressed')      # names as in image_transport
# Processing is too slow for the thread that receives if an image takes longer, or if more wait in
# its socket; it is left to the loop for this time.
_MAX_PROCESSING_S, _MAX_WAITING = 0.03, 1
_LATE_S = 1.0


class RawInput:
    """Subscribes to raw images.

    An image is processed in the thread that receives it: this saves the change to another thread.
    When that takes too long for the rate of the images, it is left to the loop for a while, so
    that images are received meanwhile and the loop gets the newest.

    take, wake: those of a LatestValue with the message that is left to the loop.
    decode: from_msg of ColorImages.
    """

    def __init__(self, topic: str, counts: RecognitionDiagnostics, max_pixels: int,
                 process: Callable[[Image], bool], now: Callable[[], float] = time.monotonic):
        """Subscribe to the topic.

        max_pixels: larger images are refused.
        process: is called with an image, in any thread; returns whether it was processed. If it
        was not, the image is left to the loop.
        """
        self._counts, self._process, self._now = counts, process, now
        self._late_until_s = now()
        self._latest = LatestValue()
        self.take, self.wake = self._latest.take, self._latest.wake
        self.decode = ColorImages(max_pixels).from_msg
        ImageSubscriber(topic, self._receive, counts.refused.add)

    def done(self, seconds: float) -> None:
        """Take note of how long the processing of an image took."""
        if seconds > _MAX_PROCESSING_S:
            self._be_late()

    def _receive(self, msg: Image) -> None:
        self._counts.received.add()
        if getattr(msg, 'waiting', 0) > _MAX_WAITING:       # plain rospy does not know it
            self._be_late()
        if self._now() < self._late_until_s or not self._process(msg):
            if self._latest.put(msg) is not None:
                self._counts.replaced.add()
                self._be_late()

    def _be_late(self) -> None:
        self._late_until_s = self._now() + _LATE_S


class CompressedInput:
    """Subscribes to compressed images. Decoding takes long, so all are left to the loop.

    take, wake: as of RawInput.
    """

    def __init__(self, topic: str, counts: RecognitionDiagnostics, max_pixels: int):
        """Subscribe to topic/compressed, where `topic` has the raw images.

        max_pixels: larger images are refused before they are decoded.
        """
        self._counts, self._max_pixels = counts, max_pixels
        self._latest = LatestValue()
        self.take, self.wake = self._latest.take, self._latest.wake
        rospy.Subscriber(rospy.resolve_name(topic) + '/compressed', CompressedImage, self._receive,
                         queue_size=1, buff_size=1 << 24, tcp_nodelay=True)

    def decode(self, msg: CompressedImage) -> Tuple[np.ndarray, str]:
        """Return the image in bgr8, and its encoding.

        Raises ImageError naming format, size and reason.
        """
        return compressed_image_msgs.from_msg(msg, self._max_pixels), 'bgr8'

    def done(self, seconds: float) -> None:
        """Do nothing: all images are left to the loop."""

    def _receive(self, msg: CompressedImage) -> None:
        self._counts.received.add()
        if self._latest.put(msg) is not None:
            self._counts.replaced.add()


def subscribe(transport: str, topic: str, counts: RecognitionDiagnostics, max_pixels: int,
              process: Callable[[Image], bool]) -> Union[RawInput, CompressedInput]:
    """Return the input for a transport, one of TRANSPORTS; the other arguments are RawInput's."""
    if transport == 'compressed':
        return CompressedInput(topic, counts, max_pixels)
    return RawInput(topic, counts, max_pixels, process)
