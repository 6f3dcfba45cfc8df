"""The images that are to be recognized: each as it arrives, or the newest of them."""
import math
import time
from typing import Callable, Union

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


class ImageInput:
    """Subscribes to images, raw or compressed.

    A raw image is processed in the thread that receives it: this saves the change to another
    thread. When that takes too long for the rate of the images, it is left to the loop for a
    while, so that images are received meanwhile and the loop gets the newest. Decoding a
    compressed image takes long: all are left to the loop.

    take, wake: those of a LatestValue with the message that is left to the loop.
    decode: returns the image of a message, and its encoding; raises ImageError.
    """

    def __init__(self, topic: str, transport: str, counts: RecognitionDiagnostics, max_pixels: int,
                 process: Callable[[Image], bool], now: Callable[[], float] = time.monotonic):
        """Subscribe.

        topic: of the raw images; transport: one of TRANSPORTS.
        max_pixels: larger images are refused, compressed ones before they are decoded.
        process: is called with an image, in any thread; returns whether it was processed. If it
        was not, the image is left to the loop.
        """
        self._counts, self._process, self._now = counts, process, now
        self._latest = LatestValue()
        self.take, self.wake = self._latest.take, self._latest.wake
        if transport == 'raw':
            self._late_until_s = now()
            self.decode = ColorImages(max_pixels).from_msg
            ImageSubscriber(topic, self._receive, counts.refused.add)
        else:
            self._late_until_s = math.inf
            self.decode = lambda msg: (compressed_image_msgs.from_msg(msg, max_pixels), 'bgr8')
            rospy.Subscriber(rospy.resolve_name(topic) + '/compressed', CompressedImage,
                             self._receive, queue_size=1, buff_size=1 << 24, tcp_nodelay=True)

    def done(self, seconds: float) -> None:
        """Take note of how long the processing of an image took."""
        if seconds > _MAX_PROCESSING_S:
            self._be_late()

    def _receive(self, msg: Union[Image, CompressedImage]) -> None:
        self._counts.received.add()
        if getattr(msg, 'waiting', 0) > _MAX_WAITING:       # plain rospy does not know it
            self._be_late()
        if self._now() < self._late_until_s or not self._process(msg):
            if self._latest.put(msg) is not None:
                self._counts.replaced.add()
                self._be_late()

    def _be_late(self) -> None:
        self._late_until_s = max(self._late_until_s, self._now() + _LATE_S)
