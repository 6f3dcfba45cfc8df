"""A subscriber for large images."""
import struct
from collections import deque
from socket import MSG_WAITALL
from typing import Callable

import genpy
import numpy as np
import rospy
from rospy.exceptions import TransportTerminated
from sensor_msgs.msg import Image

from img_recog.ros.throttle import ThrottledWarning

_LENGTH = struct.Struct('<I')
# of the fields of a serialized Image that come before its texts and its data
_STAMP_END, _SIZE_BYTES, _STEP_BYTES = 12, 8, 5
_NOTHING = np.empty(0, np.uint8)
_MOST_SPARE = 4         # memory that is more than so many times too large is given back


class _KeptImage(Image):
    """An image whose data lies in `memory`, which is kept."""

    memory = None


class ImageSubscriber:
    """Receives images straight into memory that is kept, and asks publishers for no delay.

    rospy reads a message in pieces, puts these together, cuts the message out and its data out of
    that: four times new memory for each image, which takes longer than to convert it. Here the
    kernel writes it where it stays.
    """

    def __init__(self, name: str, callback: Callable[[Image], None]):
        """Subscribe to `name`; `callback` has the images in threads of rospy.

        The data of an image is a memoryview, and is its own until `release`.
        """
        self._free = deque()
        self._warn = ThrottledWarning()
        self._subscriber = rospy.Subscriber(name, Image, callback, queue_size=1, tcp_nodelay=True)
        topic = self._subscriber.impl
        with topic.c_lock:
            self._add_connection = topic.add_connection
            topic.add_connection = self._connect
            for connection in topic.connections:
                self._take_over(connection)

    def release(self, msg: Image) -> None:
        """Let the memory of an image be used for another; the image is of no use any more."""
        memory = getattr(msg, 'memory', None)
        if memory is not None:
            msg.memory, msg.data = None, b''
            self._free.append(memory)

    def _connect(self, connection) -> bool:
        self._take_over(connection)
        return self._add_connection(connection)

    def _take_over(self, connection) -> None:
        protocol = connection.protocol
        if protocol is None:        # closed meanwhile
            return
        ordinary = protocol.read_messages

        def read_messages(buffer, messages, sock):
            # of what follows, rospy shall read no more than the length
            protocol.buff_size = _LENGTH.size
            length, begun = _LENGTH.unpack(buffer.getbuffer()[:_LENGTH.size])[0], buffer.tell()
            if begun - _LENGTH.size > length:       # several small ones, at the start
                ordinary(buffer, messages, sock)
                return
            memory = self._memory(length)
            view = memoryview(memory)[:length]
            at = begun - _LENGTH.size
            view[:at] = buffer.getbuffer()[_LENGTH.size:begun]
            while at < length:
                at += _received(sock, view[at:])
            buffer.seek(0)
            try:
                messages.append(_image(memory, view))
            except (genpy.DeserializationError, struct.error, ValueError) as error:
                self._free.append(memory)
                self._warn('image of %s skipped: its %d bytes are no sensor_msgs/Image: %s',
                           connection.endpoint_id, length, error)
        protocol.read_messages = read_messages

    def _memory(self, size: int) -> np.ndarray:
        try:
            memory = self._free.popleft()
        except IndexError:
            memory = _NOTHING
        if size <= len(memory) <= _MOST_SPARE * size:
            return memory
        # not cleared, so that a length that is never sent takes no memory
        return np.empty(size, np.uint8)


def _received(sock, view: memoryview) -> int:
    try:
        count = sock.recv_into(view, 0, MSG_WAITALL)
    except OSError as error:
        raise TransportTerminated(str(error))
    if count == 0:
        raise TransportTerminated('the publisher has closed the connection')
    return count


def _image(memory: np.ndarray, view: memoryview) -> Image:
    """Return the message that is serialized in `view`, its data left where it is."""
    at = _after_text(view, _STAMP_END) + _SIZE_BYTES        # frame_id, height and width
    at = _after_text(view, at) + _STEP_BYTES                # encoding, is_bigendian and step
    msg = _KeptImage()
    msg.deserialize(bytes(view[:at]) + _LENGTH.pack(0))
    size, = _LENGTH.unpack_from(view, at)
    data = view[at + _LENGTH.size:]
    if len(data) < size:
        raise ValueError('its data ends early')
    msg.data, msg.memory = data[:size], memory
    return msg


def _after_text(view: memoryview, at: int) -> int:
    return at + _LENGTH.size + _LENGTH.unpack_from(view, at)[0]
