"""Publishers for large messages: images and clouds of points."""
import io
import math
import struct
import weakref
from typing import Any, Callable, Optional, Tuple, Union

import numpy as np
from sensor_msgs.msg import Image, PointCloud2
from std_msgs.msg import Header

from img_recog.processes import memory
from img_recog.ros.transport.outbox import Packet
from img_recog.ros.transport.outbox_publisher import OutboxPublisher
from img_recog.ros.transport.redelivery import Redelivery

# Writes data into an array of a given shape, uint8, whose content is arbitrary.
Draw = Callable[[np.ndarray], None]

_LENGTH = struct.Struct('<I')
_BYTES_BEHIND = {Image: 0, PointCloud2: 1}      # of fields that follow the data on the wire


class LargePublisher(OutboxPublisher):
    """Sends messages with much data, which are drawn into the bytes that are sent.

    rospy copies each image into a message and that into a buffer: a frame whose images are viewed
    then takes 56 % (39 % to 59 %) more CPU time at 640x480. Here each subscriber has an Outbox: it
    never blocks the publisher. Without the memory of the last message, a frame takes 4 % more.
    Use it from one thread at a time.
    """

    def __init__(self, name: str, data_class: type, redelivery: Optional[Redelivery] = None):
        """Advertise the topic `name`.

        data_class: sensor_msgs/Image or PointCloud2. redelivery: sends the messages, which are
        drawn then also if there is no subscriber yet.
        """
        memory.keep()
        # memory of the last message, which is used again if nobody has it
        self._data, self._sent = np.empty(0, np.uint8), lambda: None    # type: Any, Any
        self._layout: Any = None
        self._note: Any = None      # of what is in it; None: it is arbitrary
        super().__init__('image_publisher', name, data_class, 1, redelivery=redelivery)

    def _is_wanted(self) -> bool:
        return self._redelivery is not None or self._publisher.get_num_connections() > 0

    def publish_data(self, draw: Draw, shape: tuple, msg: Union[Image, PointCloud2]) -> None:
        """Publish a message, whose data are drawn only if there are subscribers.

        shape: of the data; msg: the message without data.
        """
        topic = self._publisher.impl
        if topic is None or not self._is_wanted():
            return
        if self._is_plain:
            data, self._note = np.empty(shape, np.uint8), None
            draw(data)
            msg.data = data.tobytes()
            self._publisher.publish(msg)
            return
        topic.seq += 1
        msg.header.seq = topic.seq
        size = math.prod(shape)
        head, tail = _around_data(msg, size)
        layout = len(head), shape, len(tail)
        if layout != self._layout or self._sent() is not None:      # an outbox has it still
            self._layout, self._note = layout, None
            self._data = np.empty(len(head) + size + len(tail), np.uint8)
        view = self._data.data
        view[:len(head)], view[len(head) + size:] = head, tail
        draw(self._data[len(head):len(head) + size].reshape(shape))
        sent = self._data[:]
        packet, self._sent = Packet(sent.data), weakref.ref(sent)
        del sent        # only the packet has it
        self._send(packet, topic)


class ImagePublisher(LargePublisher):
    """Publishes images."""

    def __init__(self, name: str, redelivery: Optional[Redelivery] = None):
        """Advertise the topic `name`; see LargePublisher."""
        super().__init__(name, Image, redelivery)

    def publish(self, image: np.ndarray, encoding: str, header: Header) -> None:
        """Publish an image if there are subscribers.

        image: uint8 of shape (height, width[, channels]).
        encoding: of 8-bit channels, as in sensor_msgs/image_encodings.h.
        """
        shape = image.shape if image.ndim == 3 else image.shape + (1,)
        self.publish_drawn(lambda result, _: np.copyto(result, image.reshape(shape)), shape,
                           encoding, header)

    def publish_drawn(self, draw: Callable[[np.ndarray, Any], Any], shape: tuple, encoding: str,
                      header: Header) -> None:
        """Publish an image, which is drawn only if there are subscribers.

        draw: writes it into an array. Its second argument is what `draw` returned when it wrote to
        the same memory before, which has kept its content; if that is None, this is arbitrary.
        shape: (height, width, channels); encoding: as for `publish`.
        """
        if not self._is_wanted():
            return
        height, width, channels = shape

        def draw_over(result: np.ndarray) -> None:
            note, self._note = self._note, None     # if it raises an error
            self._note = draw(result, note)
        self.publish_data(draw_over, shape, Image(
            Header(0, header.stamp, header.frame_id), height, width, encoding, 0,
            width * channels, b''))


def _around_data(msg: Union[Image, PointCloud2], size: int) -> Tuple[bytes, bytes]:
    """Return the bytes before and behind the data on the wire; msg has no data."""
    buffer = io.BytesIO()
    msg.serialize(buffer)
    fields = buffer.getvalue()
    behind = len(fields) - _BYTES_BEHIND[type(msg)]
    return b''.join((_LENGTH.pack(len(fields) + size), fields[:behind - _LENGTH.size],
                     _LENGTH.pack(size))), fields[behind:]
