"""A subscriber for large images."""
import socket
import struct
from collections import deque
from typing import Callable, Deque, Optional

import genpy
import numpy as np
import rospy
from rospy.exceptions import TransportTerminated
from sensor_msgs.msg import Image

from img_recog.errors import one_line, shortened
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.ros.transport.sockets import waiting_bytes
from img_recog.ros.transport.switch import is_plain

_LENGTH = struct.Struct('<I')
# sizes of the fields of a serialized Image before its strings and its data, bytes
_STAMP_END, _SIZE_BYTES, _STEP_BYTES = 12, 8, 5
_EMPTY = np.empty(0, np.uint8)
_MAX_OVERSIZE = 4       # a buffer more than this many times larger than an image is dropped
_MAX_LENGTH = (1 << 32) - 1
_SCRATCH_BYTES = 1 << 16
_PLAIN_BUFFER_BYTES = 1 << 26       # larger than a message: rospy reads this much at once


class _BufferedImage(Image):
    """An image whose data is in the reused buffer `memory`.

    waiting: how many complete images of its size are behind it in the socket.
    """

    memory: Optional[np.ndarray] = None
    waiting = 0


class ImageSubscriber:
    """Receives images directly into reused buffers, and requests TCP_NODELAY.

    rospy reads a message in parts, joins them, and copies the message and then its data. This
    allocates memory four times per image, and takes longer than converting it. Here the kernel
    writes the data to its final place.

    The callback must return before the next image comes, for example after storing this one in a
    LatestValue: the next images wait in the socket meanwhile.

    Other subscribers to the topic in the same process get copies of the images.
    """

    def __init__(self, name: str, callback: Callable[[Image], None], max_bytes: int = _MAX_LENGTH,
                 refuse: Callable[[str], None] = lambda reason: None):
        """Subscribe to `name`; `callback` is called with each image, in a thread of rospy.

        The data of an image may be a memoryview, which does not change until `release`.
        max_bytes: a longer message is read and dropped, so that a wrong length takes no memory;
        not with plain rospy.
        refuse: is called with the reason for each message that is dropped.
        """
        self._callback, self._max_bytes, self._refuse = callback, max_bytes, refuse
        self._free: Deque[np.ndarray] = deque()
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

    def release(self, msg: Image) -> None:
        """Allow the buffer of an image to be reused; the image has no data afterwards."""
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
            # so that rospy reads only the length of the next message
            protocol.buff_size = _LENGTH.size
            length, received = _LENGTH.unpack(buffer.getbuffer()[:_LENGTH.size])[0], buffer.tell()
            if received - _LENGTH.size > length:        # several small images, at the start
                ordinary(buffer, messages, sock)
                for msg in messages:
                    self._call(msg)
                return
            if length > self._max_bytes:
                self._drop(connection, length, 'at most {} are read'.format(self._max_bytes))
                _discard(sock, length - (received - _LENGTH.size))
                buffer.seek(0)
                return
            memory = self._memory(length)
            view = memoryview(memory)[:length]
            view[:received - _LENGTH.size] = buffer.getbuffer()[_LENGTH.size:received]
            buffer.seek(0)
            _fill(sock, view[received - _LENGTH.size:])
            try:
                msg = _image(memory, view)
            except (genpy.DeserializationError, struct.error, ValueError) as error:
                self._free.append(memory)
                self._drop(connection, length, 'no sensor_msgs/Image: ' + one_line(error))
            else:
                msg.waiting = waiting_bytes(sock) // (len(msg.data) or 1)
                self._deliver(msg, view, connection, messages)
        protocol.read_messages = read_messages

    def _drop(self, connection, length: int, reason: str) -> None:
        reason = 'image of {} skipped: {} bytes, {}'.format(
            shortened(connection.endpoint_id), length, reason)
        self._refuse(reason)
        self._warn('%s', reason)

    def _deliver(self, msg: _BufferedImage, view: memoryview, connection, messages: list) -> None:
        """Call our callback; append a copy to `messages` if rospy needs the message."""
        if self._topic.callbacks or self._topic.statistics_logger or connection.is_latched:
            messages.append(Image().deserialize(bytes(view)))
        else:
            connection.stat_num_msg += 1        # rospy counts only those in `messages`
        msg._connection_header = connection.header
        self._call(msg)

    def _call(self, msg: Image) -> None:
        self._topic._invoke_callback(msg, self._callback, None)

    def _memory(self, size: int) -> np.ndarray:
        try:
            memory = self._free.popleft()
        except IndexError:
            memory = _EMPTY
        if size <= len(memory) <= _MAX_OVERSIZE * size:
            return memory
        # not cleared: a wrong length in a message then uses no physical memory
        return np.empty(size, np.uint8)


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


def _discard(sock: socket.socket, count: int) -> None:
    """Read so many bytes from a socket and forget them."""
    scratch = memoryview(bytearray(min(count, _SCRATCH_BYTES)))
    while count > 0:
        _fill(sock, scratch[:count])
        count -= len(scratch)


def _image(memory: np.ndarray, view: memoryview) -> _BufferedImage:
    """Return the message that is serialized in `view`, a part of `memory`; share its data."""
    end = _after_text(view, _STAMP_END) + _SIZE_BYTES       # frame_id, height and width
    end = _after_text(view, end) + _STEP_BYTES              # encoding, is_bigendian and step
    size, = _LENGTH.unpack_from(view, end)
    data = view[end + _LENGTH.size:]
    if len(data) < size:
        raise ValueError('its data ends early')
    msg = _BufferedImage().deserialize(bytes(view[:end]) + _LENGTH.pack(0))
    msg.data, msg.memory = data[:size], memory
    return msg


def _after_text(view: memoryview, start: int) -> int:
    return start + _LENGTH.size + _LENGTH.unpack_from(view, start)[0]
