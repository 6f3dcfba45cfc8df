"""A subscriber for large images."""
import fcntl
import functools
import socket
import struct
import termios
from collections import deque
from typing import Callable, Deque, Iterable, Iterator, Optional

import genpy
import numpy as np
import rospy
from rospy.exceptions import TransportTerminated
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.errors import one_line, shortened
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.switch import is_plain

_LENGTH, _WAITING = struct.Struct('<I'), struct.Struct('i')
_NUMBERS = struct.Struct('<III')        # seq and stamp
# sizes of the fields of a serialized Image before its strings and its data, bytes
_STAMP_END, _SIZE_BYTES, _STEP_BYTES = 12, 8, 5
_EMPTY = np.empty(0, np.uint8)
_MAX_OVERSIZE = 4       # a buffer more than this many times larger than an image is dropped
_MAX_LENGTH = (1 << 32) - 1
_SCRATCH_BYTES = 1 << 16
# of a message that is worked on while it arrives; its header with usual texts is shorter
_MIN_BYTES_IN_PARTS, _HEADER_BYTES = 1 << 17, 256
_PLAIN_BUFFER_BYTES = 1 << 26       # larger than a message: rospy reads this much at once


class _BufferedImage(Image):
    """An image whose data is in the reused buffer `memory`.

    data_start: the number of bytes before the data, on the wire.
    sock: that it came from.
    """

    memory: Optional[np.ndarray] = None
    sock: Optional[socket.socket] = None
    data_start = 0


class ImageSubscriber:
    """Receives images directly into reused buffers, and requests TCP_NODELAY.

    rospy reads a message in parts, joins them, and copies the message and then its data. This
    allocates memory four times per image, and takes longer than converting it. Here the kernel
    writes the data to its final place.

    The callback must return soon, for example after storing the image in a LatestValue: the next
    images wait in the socket meanwhile.

    Other subscribers to the topic in the same process get copies of the images.
    """

    def __init__(self, name: str, callback: Callable[[Image], None], max_bytes: int = _MAX_LENGTH,
                 refuse: Callable[[str], None] = lambda reason: None,
                 begin: Callable[[Image], Iterable[int]] = lambda msg: ()):
        """Subscribe to `name`; `callback` is called with each image, in a thread of rospy.

        The data of an image may be a memoryview, which does not change until `release`.
        max_bytes: a longer message is read and dropped, so that a wrong length takes no memory;
        not with plain rospy.
        refuse: is called with the reason for each message that is dropped.
        begin: may work on an image while it arrives: it is called when the header is there, with
        the image, whose data is not complete; each number that it yields is how many bytes of the
        data must be there before it goes on. Not with plain rospy, nor with small images.
        """
        self._callback, self._max_bytes, self._refuse = callback, max_bytes, refuse
        self._begin = begin
        self._first_bytes = 0, 0
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

    def get_num_connections(self) -> int:
        """Return the number of publishers."""
        return self._subscriber.get_num_connections()

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
            arrival = _Arrival(sock, memoryview(memory)[:length],
                               buffer.getbuffer()[_LENGTH.size:received])
            buffer.seek(0)
            try:
                msg = self._receive(arrival, memory)
            except (genpy.DeserializationError, struct.error, ValueError) as error:
                self._free.append(memory)
                self._drop(connection, length, 'no sensor_msgs/Image: ' + one_line(error))
            else:
                self._deliver(msg, arrival.view, connection, messages)
        protocol.read_messages = read_messages

    def _receive(self, arrival: '_Arrival', memory: np.ndarray) -> _BufferedImage:
        """Return the message when it is complete; meanwhile let `begin` work on it."""
        length = len(arrival.view)
        if length < _MIN_BYTES_IN_PARTS:
            arrival.wait_for(length)
            return _image(memory, arrival.view)
        # with the header, what the first step wanted of the last image of this length
        last_length, first_bytes = self._first_bytes
        arrival.wait_for(first_bytes if last_length == length else _HEADER_BYTES)
        try:
            msg = _image(memory, arrival.view, arrival.count)
        except (genpy.DeserializationError, struct.error, ValueError):  # long texts, or no image
            arrival.wait_for(length)
            return _image(memory, arrival.view)
        is_first = True
        for wanted in self._steps(msg):
            end = msg.data_start + min(max(0, wanted), len(msg.data))
            if is_first:
                self._first_bytes, is_first = (length, end), False
            arrival.wait_for(end)
        arrival.wait_for(length)
        return msg

    def _steps(self, msg: _BufferedImage) -> Iterator[int]:
        """Yield what `begin` yields; log an error of it like rospy logs those of a callback."""
        try:
            yield from self._begin(msg)
        except Exception as error:
            def fail(_, error=error):
                raise error
            self._topic._invoke_callback(msg, fail, None)

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
        msg._connection_header, msg.sock = connection.header, connection.socket
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


def backlog(msg: Image) -> int:
    """Return how many complete images of this size wait in the socket that it came from.

    To be called in the callback of an ImageSubscriber. 0 with plain rospy, and after the
    connection is closed.
    """
    sock = getattr(msg, 'sock', None)
    if sock is None:
        return 0
    try:
        waiting, = _WAITING.unpack(fcntl.ioctl(sock, termios.FIONREAD, _WAITING.pack(0)))
    except (OSError, ValueError):
        return 0
    return waiting // (len(msg.data) or 1)


class _Arrival:
    """A message while it arrives.

    view: the memory for all of it; count: how many bytes of it are there.
    """

    def __init__(self, sock, view: memoryview, begun: memoryview):
        self.view, self.count = view, len(begun)
        self._sock = sock
        view[:self.count] = begun

    def wait_for(self, count: int) -> None:
        """Wait until the first `count` bytes are there."""
        while self.count < count:
            self.count += _receive(self._sock, self.view[self.count:count])


def _receive(sock, view: memoryview) -> int:
    """Fill a view from a socket; return the number of bytes, which is less only after a signal.

    Raises TransportTerminated when the connection ends.
    """
    try:
        count = sock.recv_into(view, 0, socket.MSG_WAITALL)
    except OSError as error:
        raise TransportTerminated(str(error))
    if count == 0:
        raise TransportTerminated('the publisher has closed the connection')
    return count


def _discard(sock, count: int) -> None:
    """Read so many bytes from a socket and forget them."""
    scratch = memoryview(bytearray(min(count, _SCRATCH_BYTES)))
    while count > 0:
        count -= _receive(sock, scratch[:count])


def _image(memory: np.ndarray, view: memoryview, count: Optional[int] = None) -> _BufferedImage:
    """Return the message that is serialized in `view`, without copying its data.

    count: how many bytes of it are there, at least all before the data; None for all.
    """
    there = view[:count]
    end = _after_text(there, _STAMP_END) + _SIZE_BYTES      # frame_id, height and width
    end = _after_text(there, end) + _STEP_BYTES             # encoding, is_bigendian and step
    size, = _LENGTH.unpack_from(there, end)
    seq, secs, nsecs = _NUMBERS.unpack_from(there, 0)
    serialized = bytes(there[_STAMP_END:end])
    # long texts are not kept
    frame_id, *fields = (_kept_fields(serialized) if end < _HEADER_BYTES
                         else _fields(serialized))
    data_start = end + _LENGTH.size
    data = view[data_start:]
    if len(data) < size:
        raise ValueError('its data ends early')
    stamp = genpy.Time()
    stamp.secs, stamp.nsecs = secs, nsecs       # as they are, like genpy
    msg = _BufferedImage(Header(seq, stamp, frame_id), *fields, data[:size])
    msg.data_start, msg.memory = data_start, memory
    return msg


def _fields(serialized: bytes) -> tuple:
    """Return the fields of an image between its stamp and its data."""
    msg = Image().deserialize(bytes(_STAMP_END) + serialized + _LENGTH.pack(0))
    return (msg.header.frame_id, msg.height, msg.width, msg.encoding, msg.is_bigendian, msg.step)


_kept_fields = functools.lru_cache(maxsize=8)(_fields)      # from image to image they are the same


def _after_text(view: memoryview, start: int) -> int:
    return start + _LENGTH.size + _LENGTH.unpack_from(view, start)[0]
