"""A subscriber for large images."""
import socket
import struct
from typing import Callable

import genpy
import numpy as np
import rospy
from rospy.exceptions import TransportTerminated
from sensor_msgs.msg import Image

from img_recog.errors import one_line, shortened
from img_recog.processes import memory
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.sockets import waiting_bytes
from img_recog.ros.transport.switch import is_plain

_LENGTH = struct.Struct('<I')
# sizes of the fields of a serialized Image before its strings and its data, bytes
_STAMP_END, _SIZE_BYTES, _STEP_BYTES = 12, 8, 5
_PLAIN_BUFFER_BYTES = 1 << 26       # larger than a message: rospy reads this much at once


class _ReceivedImage(Image):
    """waiting: how many complete images of its size are behind it in the socket."""

    waiting = 0


class ImageSubscriber:
    """Receives images without copies, and requests TCP_NODELAY.

    rospy reads a message in parts, joins them, and copies the message and then its data: a frame
    takes 77 % (56 % to 80 %) more CPU time viewed, 59 % (50 % to 113 %) alone. Here the kernel
    writes the data to its final place.

    The callback must return before the next image comes, for example after storing this one in a
    LatestValue: the next images wait in the socket meanwhile.

    Other subscribers to the topic in the same process get copies of the images.
    """

    def __init__(self, name: str, callback: Callable[[Image], None],
                 refuse: Callable[[str], None] = lambda reason: None):
        """Subscribe to `name`; `callback` is called with each image, in a thread of rospy.

        The data of an image may be a memoryview.
        refuse: is called with the reason for each message that is no image; not with plain rospy.
        """
        memory.keep()
        self._callback, self._refuse = callback, refuse
        self._warn = ThrottledWarning()
        if is_plain('image_subscriber'):
            self._subscriber = rospy.Subscriber(name, Image, callback, queue_size=1,
                                                buff_size=_PLAIN_BUFFER_BYTES, tcp_nodelay=True)
            return
        # without a callback: rospy would pass the same message to all callbacks of the process
        self._subscriber = rospy.Subscriber(name, Image, queue_size=1, tcp_nodelay=True)
        self._topic = self._subscriber.impl
        with self._topic.c_lock:
            if 'add_connection' in vars(self._topic):       # another ImageSubscriber replaced it
                self._topic.add_callback(callback, None)
                return
            self._add_connection = self._topic.add_connection
            self._topic.add_connection = self._connect
            for connection in self._topic.connections:
                self._take_over(connection)

    def close(self) -> None:
        """Unsubscribe. The callback may be called once more."""
        self._subscriber.unregister()

    def _connect(self, connection) -> bool:
        self._take_over(connection)
        return self._add_connection(connection)

    def _take_over(self, connection) -> None:
        protocol = connection.protocol
        if protocol is None:        # closed meanwhile
            return
        ordinary = protocol.read_messages

        def read_messages(buffer, messages, sock):
            # so that rospy reads only the length of the next message
            protocol.buff_size = _LENGTH.size
            length, received = _LENGTH.unpack(buffer.getbuffer()[:_LENGTH.size])[0], buffer.tell()
            if received - _LENGTH.size > length:        # several small images, at the start
                ordinary(buffer, messages, sock)
                for msg in messages:
                    self._call(msg)
                return
            view = memoryview(np.empty(length, np.uint8))   # not cleared, unlike a bytearray
            view[:received - _LENGTH.size] = buffer.getbuffer()[_LENGTH.size:received]
            buffer.seek(0)
            _fill(sock, view[received - _LENGTH.size:])
            try:
                msg = _image(view)
            except (genpy.DeserializationError, struct.error, ValueError) as error:
                reason = 'image of {} skipped: {} bytes, no sensor_msgs/Image: {}'.format(
                    shortened(connection.endpoint_id), length, one_line(error))
                self._refuse(reason)
                self._warn('%s', reason)
            else:
                msg.waiting = waiting_bytes(sock) // (len(msg.data) or 1)
                self._deliver(msg, view, connection, messages)
        protocol.read_messages = read_messages

    def _deliver(self, msg: _ReceivedImage, view: memoryview, connection, messages: list) -> None:
        """Call our callback; append a copy to `messages` if rospy needs the message."""
        if self._topic.callbacks or self._topic.statistics_logger or connection.is_latched:
            messages.append(Image().deserialize(bytes(view)))
        else:
            connection.stat_num_msg += 1        # rospy counts only those in `messages`
        msg._connection_header = connection.header
        self._call(msg)

    def _call(self, msg: Image) -> None:
        self._topic._invoke_callback(msg, self._callback, None)


def _fill(sock: socket.socket, view: memoryview) -> None:
    """Fill a view from a socket. Raises TransportTerminated when the connection ends."""
    while view:
        try:
            count = sock.recv_into(view, 0, socket.MSG_WAITALL)     # less only after a signal
        except OSError as error:
            raise TransportTerminated(str(error))
        if count == 0:
            raise TransportTerminated('the publisher has closed the connection')
        view = view[count:]


def _image(view: memoryview) -> _ReceivedImage:
    """Return the message that is serialized in `view`, and shares its data."""
    end = _after_text(view, _STAMP_END) + _SIZE_BYTES       # frame_id, height and width
    end = _after_text(view, end) + _STEP_BYTES              # encoding, is_bigendian and step
    size, = _LENGTH.unpack_from(view, end)
    data = view[end + _LENGTH.size:]
    if len(data) < size:
        raise ValueError('its data ends early')
    msg = _ReceivedImage().deserialize(bytes(view[:end]) + _LENGTH.pack(0))
    msg.data = data[:size]
    return msg


def _after_text(view: memoryview, start: int) -> int:
    return start + _LENGTH.size + _LENGTH.unpack_from(view, start)[0]
