"""A publisher for large images."""
import io
import struct
from typing import Any, Callable, Optional

import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.ros.transport.direct_publisher import synchronous_publisher
from img_recog.ros.transport.outbox import Outboxes
from img_recog.ros.transport.packets import PacketPool
from img_recog.ros.transport.switch import is_plain

_LENGTH = struct.Struct('<I')
_NUMBERS = struct.Struct('<III')        # after the length: seq and stamp


class ImagePublisher:
    """Sends images from reused buffers; `publish_drawn` saves a copy of the image too.

    rospy serializes each message into new memory. Here each subscriber has an Outbox: it never
    blocks the publisher. Use it from one thread at a time.
    """

    def __init__(self, name: str, leave_large: bool = False):
        """Advertise the topic `name`.

        leave_large: whether to send large images in threads, so that the caller goes on meanwhile:
        more images a second, which arrive later and less regularly. Not with plain rospy.
        """
        self._leave_large = leave_large
        self._is_plain = is_plain('image_publisher')
        self._publisher = (rospy.Publisher(name, Image, queue_size=1) if self._is_plain
                           else synchronous_publisher(name, Image))
        self._pool, self._outboxes = PacketPool(), Outboxes()
        self._layout: tuple = ()
        self._head = bytearray()        # the bytes before the data for this layout

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return self._publisher.get_num_connections()

    def unregister(self) -> None:
        """Stop to advertise; what is published from now on is dropped."""
        self._publisher.unregister()

    def publish(self, image: np.ndarray, encoding: str, header: Header) -> None:
        """Publish an image if there are subscribers.

        image: uint8 of shape (height, width[, channels]). If it is read-only, it must not change
        later either: to publish it again then takes no copy.
        encoding: of 8-bit channels, as in sensor_msgs/image_encodings.h.
        """
        shape = image.shape if image.ndim == 3 else image.shape + (1,)

        def copy(result: np.ndarray, copied: Optional[np.ndarray]) -> Optional[np.ndarray]:
            if copied is not image:
                np.copyto(result, image.reshape(shape))
            return None if image.flags.writeable else image
        self.publish_drawn(copy, shape, encoding, header)

    def publish_drawn(self, draw: Callable[[np.ndarray, Any], Any], shape: tuple, encoding: str,
                      header: Header) -> None:
        """Publish an image, which is drawn only if there are subscribers.

        draw: writes the image into a uint8 array of that shape. Its second argument is what `draw`
        returned when it wrote to the same memory before, which has kept its content; if that is
        None, the content is arbitrary.
        shape: (height, width, channels).
        encoding: as for `publish`.
        """
        if self._is_plain:
            if self._publisher.get_num_connections() > 0:
                image = np.empty(shape, np.uint8)
                draw(image, None)
                msg = _without_data(header, 0, encoding, shape)
                msg.data = image.tobytes()
                self._publisher.publish(msg)
            return
        topic = self._publisher.impl
        if topic is None:
            return
        connections = topic.connections
        self._outboxes.follow(connections)
        if not connections:
            return
        topic.seq += 1
        head = self._head_of(header, topic.seq, encoding, shape)
        size = shape[0] * shape[1] * shape[2]
        packet = self._pool.take(len(head) + size)
        try:
            packet.data[:len(head)] = head
            image = np.frombuffer(packet.data, np.uint8, size, len(head)).reshape(shape)
            layout, drawn = packet.note
            packet.note = None, None        # if it raises an error, the content is arbitrary
            packet.note = (len(head), shape), draw(
                image, drawn if layout == (len(head), shape) else None)
            self._outboxes.put(packet, self._leave_large)
        finally:
            packet.release()

    def _head_of(self, header: Header, seq: int, encoding: str, shape: tuple) -> bytearray:
        """Return the bytes that precede the image data on the wire; they last until the next call.

        Only their numbers change from image to image.
        """
        layout = header.frame_id, encoding, shape
        if layout != self._layout:
            self._head = bytearray(_serialized_head(_without_data(header, seq, encoding, shape)))
            self._layout = layout
        _NUMBERS.pack_into(self._head, _LENGTH.size, seq, header.stamp.secs, header.stamp.nsecs)
        return self._head


def _without_data(header: Header, seq: int, encoding: str, shape: tuple) -> Image:
    height, width, channels = shape
    return Image(Header(seq, header.stamp, header.frame_id), height, width, encoding, 0,
                 width * channels, b'')


def _serialized_head(msg: Image) -> bytes:
    """Return the bytes that precede the image data on the wire; `msg` has no data."""
    size = msg.height * msg.step
    buffer = io.BytesIO(_LENGTH.pack(0))
    buffer.seek(0, io.SEEK_END)
    msg.serialize(buffer)
    buffer.seek(-_LENGTH.size, io.SEEK_END)
    buffer.write(_LENGTH.pack(size))
    length = buffer.tell() - _LENGTH.size + size
    buffer.seek(0)
    buffer.write(_LENGTH.pack(length))
    return buffer.getvalue()
