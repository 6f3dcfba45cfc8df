"""A publisher for large images."""
import io
import struct
import time
from typing import Callable

import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.ros.transport.direct_publisher import synchronous_publisher
from img_recog.ros.transport.packets import PacketPool, PacketSenders
from img_recog.ros.transport.switch import is_plain

_LENGTH = struct.Struct('<I')


class ImagePublisher:
    """Sends images from reused buffers; `publish_drawn` saves a copy of the image too.

    rospy serializes each message into new memory. Here each subscriber has a thread that sends
    the newest image; a subscriber that does not read blocks only its thread. Use it from one
    thread.
    """

    def __init__(self, name: str):
        """Advertise the topic `name`."""
        self._is_plain = is_plain('image_publisher')
        self._publisher = (rospy.Publisher(name, Image, queue_size=1) if self._is_plain
                           else synchronous_publisher(name, Image))
        self._pool, self._senders = PacketPool(), PacketSenders()

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return self._publisher.get_num_connections()

    def publish(self, image: np.ndarray, encoding: str, header: Header) -> None:
        """Publish an image if there are subscribers.

        image: uint8 of shape (height, width[, channels]).
        encoding: of 8-bit channels, as in sensor_msgs/image_encodings.h.
        """
        shape = image.shape if image.ndim == 3 else image.shape + (1,)
        self.publish_drawn(lambda result: np.copyto(result, image.reshape(shape)), shape, encoding,
                           header)

    def publish_drawn(self, draw: Callable[[np.ndarray], None], shape: tuple, encoding: str,
                      header: Header) -> None:
        """Publish an image, which is drawn only if there are subscribers.

        draw: writes the image into a uint8 array of that shape, whose content is arbitrary.
        shape: (height, width, channels).
        encoding: as for `publish`.
        """
        if self._is_plain:
            if self._publisher.get_num_connections() > 0:
                image = np.empty(shape, np.uint8)
                draw(image)
                msg = _without_data(header, 0, encoding, shape)
                msg.data = image.tobytes()
                self._publisher.publish(msg)
            return
        topic = self._publisher.impl
        connections = topic.connections
        self._senders.follow(connections)
        if not connections:
            return
        topic.seq += 1
        head = _head(_without_data(header, topic.seq, encoding, shape))
        size = shape[0] * shape[1] * shape[2]
        packet = self._pool.take(len(head) + size)
        try:
            packet.data[:len(head)] = head
            draw(np.frombuffer(packet.data, np.uint8, size, len(head)).reshape(shape))
            self._senders.put(packet)
        finally:
            packet.release()
        time.sleep(0)       # let the senders start now, not at the next thread switch of Python


def _without_data(header: Header, seq: int, encoding: str, shape: tuple) -> Image:
    height, width, channels = shape
    return Image(Header(seq, header.stamp, header.frame_id), height, width, encoding, 0,
                 width * channels, b'')


def _head(msg: Image) -> bytes:
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
