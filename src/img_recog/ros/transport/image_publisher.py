"""A publisher for large images."""
import io
import struct
import sys
from typing import Callable

import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Header

_LENGTH = struct.Struct('<I')


class ImagePublisher:
    """Sends images from memory that is kept, and has them drawn there where that saves a copy.

    rospy serializes a message into new memory each time; a copy into memory that was not used
    before takes several times as long as one into the same again. Each subscriber has a thread of
    rospy that sends the newest image, and holds up nobody.
    """

    def __init__(self, name: str):
        self._publisher = rospy.Publisher(name, Image, queue_size=1)
        self._packets = []

    def get_num_connections(self) -> int:
        """Return how many subscribers there are."""
        return self._publisher.get_num_connections()

    def publish(self, image: np.ndarray, encoding: str, header: Header) -> None:
        """Publish an image if anyone subscribes.

        image: uint8 of shape (height, width[, channels]).
        encoding: of 8-bit channels, as in sensor_msgs/image_encodings.h.
        """
        shape = image.shape if image.ndim == 3 else image.shape + (1,)
        self.publish_drawn(lambda result: np.copyto(result, image.reshape(shape)), shape, encoding,
                           header)

    def publish_drawn(self, draw: Callable[[np.ndarray], None], shape: tuple, encoding: str,
                      header: Header) -> None:
        """Publish an image, which is made only if anyone subscribes.

        draw: writes the image into an array of that shape, of any content before.
        shape: (height, width, channels).
        """
        topic = self._publisher.impl
        connections = topic.connections
        if not connections:
            return
        topic.seq += 1
        head = self._head(header, encoding, shape, topic.seq)
        size = shape[0] * shape[1] * shape[2]
        packet = self._packet(len(head) + size)
        packet[:len(head)] = head
        draw(np.frombuffer(packet, np.uint8, size, len(head)).reshape(shape))
        for connection in connections:
            try:
                connection.write_data(packet)
            except Exception:       # of any kind, as rospy itself has it: the subscriber is gone
                connection.close()

    @staticmethod
    def _head(header: Header, encoding: str, shape: tuple, seq: int) -> bytes:
        """Return what stands before the data on the wire."""
        height, width, channels = shape
        msg = Image(Header(seq, header.stamp, header.frame_id), height, width, encoding, 0,
                    width * channels, b'')
        buffer = io.BytesIO(_LENGTH.pack(0))
        buffer.seek(0, io.SEEK_END)
        msg.serialize(buffer)
        buffer.seek(-_LENGTH.size, io.SEEK_END)
        buffer.write(_LENGTH.pack(height * width * channels))
        size = buffer.tell() - _LENGTH.size + height * width * channels
        buffer.seek(0)
        buffer.write(_LENGTH.pack(size))
        return buffer.getvalue()

    def _packet(self, size: int) -> bytearray:
        """Return kept memory of a size that nobody sends from any more."""
        self._packets = [packet for packet in self._packets if len(packet) == size]
        for packet in self._packets:
            # this list, this name and the argument of the call: the senders have let go
            if sys.getrefcount(packet) == 3:
                return packet
        self._packets.append(bytearray(size))
        return self._packets[-1]
