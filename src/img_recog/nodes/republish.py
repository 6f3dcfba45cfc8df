"""The node image_republisher_PID: compresses images or decompresses them, as republish does.

It is used as republish of image_transport, where its plugin for compressed images is missing:
republish.py raw in:=TOPIC compressed out:=OTHER_TOPIC, or compressed in:=... raw out:=...

Subscribes to in (sensor_msgs/Image, any encoding that cv_bridge converts to bgr8) or to
in/compressed (sensor_msgs/CompressedImage), only while somebody subscribes to what it publishes.
Publishes, with the header of the image: out/compressed (sensor_msgs/CompressedImage), or
out (sensor_msgs/Image, rgb8, bgr8 or mono8).
Reads ~max_image_pixels, and in out/compressed the fields of CompressionSettings, which
dynamic_reconfigure can change.
"""
import os
from dataclasses import dataclass
from typing import List, Tuple, Union

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.conversions.image_msgs import ImageError
from img_recog.errors import UserError, shortened
from img_recog.formats.still_images import (ALLOWED_MAX_PIXELS, DEFAULT_MAX_PIXELS, ImageTooLarge,
                                            check_size)
from img_recog.nodes.compressed_images import CompressedImages
from img_recog.ros import lifecycle, parameters
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.ros.queues import LatestValue
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog.settings import Settings, setting

_RAW, _COMPRESSED = 'raw', 'compressed'
_POLL_S = 0.1
_ENCODINGS = 'bgr8', 'rgb8', 'mono8'        # that stay; all others become bgr8
_BUFFER_BYTES = 1 << 24


@dataclass(frozen=True)
class RepublishSettings(Settings):
    """Parameters of the node. max_image_pixels: a larger image is refused."""

    max_image_pixels: int = setting(DEFAULT_MAX_PIXELS, ALLOWED_MAX_PIXELS)


class _Compressor:
    """From raw images to compressed ones."""

    def __init__(self, max_pixels: int):
        self._max_pixels = max_pixels
        self.publisher = CompressedImages('out')
        self.is_wanted = self.publisher.is_wanted

    def subscribe(self, callback) -> ImageSubscriber:
        return ImageSubscriber('in', callback)

    def convert(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the pixels, which keep the buffer of the message, and their encoding."""
        try:
            check_size(msg.width, msg.height, self._max_pixels)
        except ImageTooLarge as error:
            raise ImageError(str(error))
        encoding = _kept(msg.encoding)
        return image_msgs.from_msg(msg, encoding), encoding


class _Decompressor:
    """From compressed images to raw ones."""

    def __init__(self, max_pixels: int):
        self._max_pixels = max_pixels
        self.publisher = ImagePublisher('out')

    def is_wanted(self) -> bool:
        return self.publisher.get_num_connections() > 0

    def subscribe(self, callback) -> '_Subscriber':
        return _Subscriber(rospy.resolve_name('in') + '/compressed', CompressedImage, callback,
                           queue_size=1, buff_size=_BUFFER_BYTES, tcp_nodelay=True)

    def convert(self, msg: CompressedImage) -> Tuple[np.ndarray, str]:
        """Return the pixels and their encoding: that from which they were compressed."""
        encoding = _kept(msg.format.partition(';')[0])
        return compressed_image_msgs.from_msg(msg, encoding, self._max_pixels), encoding


class _Subscriber(rospy.Subscriber):
    close = rospy.Subscriber.unregister


def _kept(encoding: str) -> str:
    return encoding if encoding in _ENCODINGS else 'bgr8'


class Republish:
    """Converts the newest image; a slow node drops images."""

    def __init__(self, words: List[str]):
        """Advertise the topics.

        words: the transports of in and out. Raises UserError if they are not these two.
        """
        if words not in ([_RAW], [_RAW, _COMPRESSED], [_COMPRESSED], [_COMPRESSED, _RAW]):
            raise UserError('got {}, wants the transports: raw compressed, or compressed raw'
                            .format(shortened(' '.join(words)) or 'nothing'),
                            'for example: republish.py raw in:=/image compressed out:=/image')
        settings = parameters.read(RepublishSettings)
        parameters.warn_of_unknown(RepublishSettings)
        max_pixels = settings.max_image_pixels
        self._way: Union[_Compressor, _Decompressor] = (
            _Compressor(max_pixels) if words[0] == _RAW else _Decompressor(max_pixels))
        self._latest, self._warn = LatestValue(), ThrottledWarning()
        lifecycle.on_shutdown(self._latest.wake)

    def spin(self) -> None:
        """Convert until the node is shut down."""
        subscriber = None
        while not rospy.is_shutdown():
            if self._way.is_wanted() and subscriber is None:
                subscriber = self._way.subscribe(self._latest.put)
            elif not self._way.is_wanted() and subscriber is not None:
                subscriber.close()
                subscriber = None
            msg = self._latest.take(_POLL_S)
            if msg is not None:
                self._republish(msg)

    def _republish(self, msg) -> None:
        try:
            image, encoding = self._way.convert(msg)
        except ImageError as error:
            self._warn('image skipped: %s', error)
            return
        self._way.publisher.publish(image, encoding, msg.header)


def main() -> int:
    """Run the node; return its exit code."""
    words = rospy.myargv()[1:]
    return lifecycle.run('image_republisher_{}'.format(os.getpid()),
                         lambda: Republish(words).spin(),
                         {'~': (RepublishSettings,), 'out/compressed/': (CompressionSettings,)})
