"""sensor_msgs/Image to and from arrays, by cv_bridge."""
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


def to_msg(image: np.ndarray, encoding: str, header: Header) -> Image:
    """Return a message that holds `image`, uint8 of shape (height, width[, channels]).

    encoding: what the array is, as in sensor_msgs/image_encodings.h.
    Raises ImageError when shape and encoding do not fit.
    """
    try:
        msg = _bridge.cv2_to_imgmsg(image, encoding)
    except CvBridgeError as error:
        raise ImageError('cannot publish an image of shape {} as {}: {}'.format(
            image.shape, encoding, error))
    msg.header = header
    return msg


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
