"""sensor_msgs/Image to and from arrays, by cv_bridge."""
import os
import struct
import sys

import cv2
import numpy as np
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.errors import UserError

_bridge = CvBridge()


class ImageError(UserError):
    """An image message cannot be converted."""


class _ArrayImage(Image):
    """An Image whose data is a view of an array and goes to the wire without further copies."""

    def serialize(self, buff) -> None:
        data, self.data = self.data, b''
        try:
            super().serialize(buff)
        finally:
            self.data = data
        # data is the last field: in place of its length, 0
        buff.seek(-4, os.SEEK_CUR)
        buff.write(struct.pack('<I', len(data)))
        buff.write(data)


def to_msg(image: np.ndarray, encoding: str, header: Header) -> Image:
    """Return a message that holds `image`, uint8 of shape (height, width[, channels]).

    encoding: what the array is, as in sensor_msgs/image_encodings.h.
    The message shares the array's memory: publish it before that changes.
    Raises ImageError when shape and encoding do not fit.
    """
    try:
        # one pixel, for what cv_bridge knows of encodings: it would copy them all
        like = _bridge.cv2_to_imgmsg(image[:1, :1], encoding)
    except CvBridgeError as error:
        raise ImageError('cannot publish an image of shape {} as {}: {}'.format(
            image.shape, encoding, error))
    rows = np.ascontiguousarray(image)
    return _ArrayImage(header=header, height=image.shape[0], width=image.shape[1],
                       encoding=like.encoding, is_bigendian=like.is_bigendian,
                       step=rows.strides[0], data=memoryview(rows).cast('B'))


def from_msg(msg: Image, encoding: str = 'bgr8') -> np.ndarray:
    """Return the image of a message in the wanted encoding, whatever its own.

    Rows may be padded (step larger than a row) and multi-byte pixels may be of either
    endianness. Raises ImageError naming the size, encoding and reason.
    """
    try:
        return _bridge.imgmsg_to_cv2(_plain(msg), encoding)
    except (CvBridgeError, cv2.error, KeyError, RuntimeError, TypeError, ValueError) as error:
        raise ImageError('cannot convert an image of {}x{}, encoding {!r}, step {}, {} bytes to '
                         '{}: {}'.format(msg.width, msg.height, msg.encoding, msg.step,
                                         len(msg.data), encoding, ' '.join(str(error).split())))


def _plain(msg: Image) -> Image:
    """Return `msg` as cv_bridge expects it: rows without a gap, pixels in this machine's order.

    cv_bridge takes the rows for unpadded, and with numpy 2 fails on the other byte order.
    """
    if msg.width == 0 or msg.height == 0:
        raise ValueError('it has no pixels')
    name, channels = _bridge.encoding_to_dtype_with_channels(msg.encoding)
    dtype = np.dtype(name)
    row = msg.width * channels * dtype.itemsize
    if msg.step < row:
        raise ValueError('a row takes {} bytes'.format(row))
    if len(msg.data) < msg.step * (msg.height - 1) + row:
        raise ValueError('the data is too short')
    foreign = bool(msg.is_bigendian) == (sys.byteorder == 'little')
    if msg.step == row and not foreign:
        return msg
    rows = np.ndarray((msg.height, row), np.uint8, msg.data, strides=(msg.step, 1))
    pixels = np.ascontiguousarray(rows).view(dtype)
    return Image(header=msg.header, height=msg.height, width=msg.width, encoding=msg.encoding,
                 is_bigendian=sys.byteorder == 'big', step=row,
                 data=(pixels.byteswap() if foreign else pixels).tobytes())
