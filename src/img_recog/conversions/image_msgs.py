"""sensor_msgs/Image to and from arrays, by cv_bridge."""
import contextlib
import sys
from typing import Tuple

import cv2
import numpy as np
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.errors import UserError

_bridge = CvBridge()
# what cv_bridge does to make bgr8 of what is no order of colors; others are left to it
_CONVERSIONS = {
    'mono8': (1, cv2.COLOR_GRAY2BGR),
    'bayer_rggb8': (1, cv2.COLOR_BayerBG2BGR), 'bayer_bggr8': (1, cv2.COLOR_BayerRG2BGR),
    'bayer_gbrg8': (1, cv2.COLOR_BayerGR2BGR), 'bayer_grbg8': (1, cv2.COLOR_BayerGB2BGR),
    'yuv422': (2, cv2.COLOR_YUV2BGR_UYVY), 'yuv422_yuy2': (2, cv2.COLOR_YUV2BGR_YUY2),
}
_COLORS = {'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4}


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
    with _refusing(msg, encoding):
        return _bridge.imgmsg_to_cv2(_plain(msg), encoding)


class ColorImages:
    """Makes color images of messages of any encoding, without a copy where there is a way.

    What needs a conversion is converted into memory that is kept from image to image.
    """

    def __init__(self):
        self._converted = np.empty((0, 0, 3), np.uint8)

    def from_msg(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the image of a message, uint8 of shape (height, width, channels), and its order.

        The order is one of bgr8, rgb8, bgra8, rgba8. The image shares the message's memory or is
        overwritten by the next. Raises ImageError naming the size, encoding and reason.
        """
        with _refusing(msg, 'bgr8'):
            if msg.encoding in _COLORS:
                return _view(msg, _COLORS[msg.encoding]), msg.encoding
            if msg.encoding in _CONVERSIONS:
                return self._convert(msg, *_CONVERSIONS[msg.encoding]), 'bgr8'
        return from_msg(msg, 'bgr8'), 'bgr8'

    def _convert(self, msg: Image, channels: int, conversion: int) -> np.ndarray:
        shape = msg.height, msg.width, 3
        image = _view(msg, channels)
        if self._converted.shape != shape:
            self._converted = np.empty(shape, np.uint8)
        cv2.cvtColor(image if channels > 1 else image[..., 0], conversion, dst=self._converted)
        return self._converted


@contextlib.contextmanager
def _refusing(msg: Image, encoding: str):
    """Raise an ImageError for whatever the conversion of `msg` to `encoding` raises."""
    try:
        yield
    except (CvBridgeError, cv2.error, KeyError, RuntimeError, TypeError, ValueError) as error:
        raise ImageError('cannot convert an image of {}x{}, encoding {!r}, step {}, {} bytes to '
                         '{}: {}'.format(msg.width, msg.height, msg.encoding, msg.step,
                                         len(msg.data), encoding, ' '.join(str(error).split())))


def _view(msg: Image, channels: int) -> np.ndarray:
    """Return the pixels of a message of 8-bit channels where they are."""
    _check_size(msg, msg.width * channels)
    return np.ndarray((msg.height, msg.width, channels), np.uint8, msg.data,
                      strides=(msg.step, channels, 1))


def _check_size(msg: Image, row: int) -> None:
    if msg.width == 0 or msg.height == 0:
        raise ValueError('it has no pixels')
    if msg.step < row:
        raise ValueError('a row takes {} bytes'.format(row))
    if len(msg.data) < msg.step * (msg.height - 1) + row:
        raise ValueError('the data is too short')


def _plain(msg: Image) -> Image:
    """Return `msg` as cv_bridge expects it: rows without a gap, pixels in this machine's order.

    cv_bridge takes the rows for unpadded, and with numpy 2 fails on the other byte order.
    """
    name, channels = _bridge.encoding_to_dtype_with_channels(msg.encoding)
    dtype = np.dtype(name)
    row = msg.width * channels * dtype.itemsize
    _check_size(msg, row)
    foreign = bool(msg.is_bigendian) == (sys.byteorder == 'little')
    if msg.step == row and not foreign:
        return msg
    rows = np.ndarray((msg.height, row), np.uint8, msg.data, strides=(msg.step, 1))
    pixels = np.ascontiguousarray(rows).view(dtype)
    return Image(header=msg.header, height=msg.height, width=msg.width, encoding=msg.encoding,
                 is_bigendian=sys.byteorder == 'big', step=row,
                 data=(pixels.byteswap() if foreign else pixels).tobytes())
