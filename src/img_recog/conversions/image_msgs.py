"""Conversion of sensor_msgs/Image to and from arrays, by cv_bridge, and of sensor_msgs/CameraInfo
to and from calibrations."""
import contextlib
import functools
import math
import re
import sys
from typing import Any, Iterator, Optional, Tuple

import cv2
import numpy as np
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from img_recog.camera.calibration import Calibration
from img_recog.errors import UserError, one_line, shortened
from img_recog.formats.still_images import ImageTooLarge, check_size

# The conversions of cv_bridge to bgr8: encoding -> (channels, code of cv2.cvtColor). Those that
# are not listed are done by cv_bridge itself.
_CONVERSIONS = {
    'mono8': (1, cv2.COLOR_GRAY2BGR),
    'bayer_rggb8': (1, cv2.COLOR_BayerBG2BGR), 'bayer_bggr8': (1, cv2.COLOR_BayerRG2BGR),
    'bayer_gbrg8': (1, cv2.COLOR_BayerGR2BGR), 'bayer_grbg8': (1, cv2.COLOR_BayerGB2BGR),
    'yuv422': (2, cv2.COLOR_YUV2BGR_UYVY), 'yuv422_yuy2': (2, cv2.COLOR_YUV2BGR_YUY2),
}
# Encodings that say a type and a number of channels only, as cv2_to_imgmsg writes them by default,
# and what is meant by most of them.
_PLAIN_ENCODING = re.compile('(8U|8S|16U|16S|32S|32F|64F)C[0-9]{1,3}')
_MEANT = {'8UC1': 'mono8', '8UC4': 'bgra8', '16UC1': 'mono16', '16UC3': 'bgr16', '16UC4': 'bgra16'}
_OF_DEPTH = '16UC1', '32FC1'     # REP 118
_COLOR_CHANNELS = {'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4}


@functools.lru_cache(maxsize=None)
def _bridge() -> Any:
    """Return a CvBridge.

    It is imported for the first image that needs it: few do, and it loads a second OpenCV, which
    would be a tenth of the start of a node.
    """
    from cv_bridge import CvBridge
    return CvBridge()


class ImageError(UserError):
    """An image message cannot be converted."""


def to_msg(image: np.ndarray, encoding: str, header: Header) -> Image:
    """Return the message for `image`, uint8 of shape (height, width[, channels]).

    encoding: that of the array, as in sensor_msgs/image_encodings.h.

    Raises ImageError when the array does not have the shape for its encoding.

    >>> msg = to_msg(np.zeros((2, 4, 3), np.uint8), 'bgr8', Header())
    >>> msg.height, msg.width, msg.step, len(msg.data)
    (2, 4, 12, 24)
    """
    try:
        msg = _bridge().cv2_to_imgmsg(image, encoding)
    except TypeError as error:          # CvBridgeError is one
        raise ImageError('cannot publish an image of shape {} as {}: {}'.format(
            image.shape, shortened(encoding), one_line(error)))
    msg.header = header
    return msg


def from_msg(msg: Image, encoding: str = 'bgr8') -> np.ndarray:
    """Return the image of a message, converted to `encoding`.

    Rows may be padded (step larger than a row) and multi-byte pixels may have either endianness.
    Raises ImageError naming the size, encoding and reason.

    >>> data = bytes([1, 2, 3, 4, 5, 6, 0, 0])
    >>> from_msg(Image(height=1, width=2, encoding='rgb8', step=8, data=data)).tolist()
    [[[3, 2, 1], [6, 5, 4]]]
    """
    with _image_errors(msg, encoding):
        return _bridge().imgmsg_to_cv2(_normalized(msg), encoding)


class ColorImages:
    """Converts messages of any encoding to color images, without a copy where possible.

    Images that need a conversion share one buffer, which is reused for the next image.
    """

    def __init__(self, max_pixels: float = math.inf):
        """Refuse images with more than `max_pixels` pixels."""
        self._max_pixels = max_pixels
        self._converted = np.empty((0, 0, 3), np.uint8)

    def from_msg(self, msg: Image) -> Tuple[np.ndarray, str]:
        """Return the image of a message and its encoding.

        The image is uint8 of shape (height, width, channels), its encoding one of bgr8,
        rgb8, bgra8, rgba8. It shares the memory of the message or is overwritten by the next call.
        Raises ImageError naming the size, encoding and reason.
        """
        try:
            check_size(msg.width, msg.height, self._max_pixels)
        except ImageTooLarge as error:
            raise ImageError(str(error))
        with _image_errors(msg, 'bgr8'):
            if msg.encoding in _COLOR_CHANNELS:
                return _view(msg, _COLOR_CHANNELS[msg.encoding]), msg.encoding
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
def _image_errors(msg: Image, encoding: str) -> Iterator[None]:
    """Turn the errors of a conversion of `msg` to `encoding` into ImageError."""
    try:
        yield
    except (cv2.error, KeyError, RuntimeError, TypeError, ValueError) as error:
        if isinstance(error, TypeError) and _PLAIN_ENCODING.fullmatch(msg.encoding):
            raise ImageError(
                'cannot convert an image of {}x{} to {}: encoding {} does not say which colors '
                'it has'.format(msg.width, msg.height, encoding, msg.encoding),
                "{0}publish it with encoding='{1}': CvBridge().cv2_to_imgmsg(image, encoding="
                "'{1}')".format('an image of depth has none; if it is another one, '
                                if msg.encoding in _OF_DEPTH else '',
                                _MEANT.get(msg.encoding, 'bgr8')))
        raise ImageError('cannot convert an image of {}x{}, encoding {}, step {}, {} bytes to '
                         '{}: {}'.format(
                             msg.width, msg.height, shortened(repr(msg.encoding)), msg.step,
                             len(msg.data), encoding, one_line(error)))


def _view(msg: Image, channels: int) -> np.ndarray:
    """Return the pixels of a message with 8-bit channels, without a copy."""
    _check_size(msg, msg.width * channels)
    return np.ndarray((msg.height, msg.width, channels), np.uint8, msg.data,
                      strides=(msg.step, channels, 1))


def _check_size(msg: Image, row_bytes: int) -> None:
    if msg.width == 0 or msg.height == 0:
        raise ValueError('it has no pixels')
    if msg.step < row_bytes:
        raise ValueError('a row takes {} bytes'.format(row_bytes))
    if len(msg.data) < msg.step * (msg.height - 1) + row_bytes:
        raise ValueError('the data is too short')


def _normalized(msg: Image) -> Image:
    """Return `msg` as cv_bridge expects it: rows without padding, in the native byte order.

    cv_bridge ignores the padding of rows, and with numpy 2 it fails on the other byte order.
    """
    name, channels = _bridge().encoding_to_dtype_with_channels(msg.encoding)
    dtype = np.dtype(name)
    row_bytes = msg.width * channels * dtype.itemsize
    _check_size(msg, row_bytes)
    swapped = bool(msg.is_bigendian) == (sys.byteorder == 'little')
    if msg.step == row_bytes and not swapped:
        return msg
    rows: np.ndarray = np.ndarray((msg.height, row_bytes), np.uint8, msg.data,
                                  strides=(msg.step, 1))
    pixels = np.ascontiguousarray(rows).view(dtype)
    return Image(header=msg.header, height=msg.height, width=msg.width, encoding=msg.encoding,
                 is_bigendian=sys.byteorder == 'big', step=row_bytes,
                 data=(pixels.byteswap() if swapped else pixels).tobytes())


def info_to_msg(calibration: Optional[Calibration], width: int, height: int,
                header: Header) -> CameraInfo:
    """Return the message for images of width x height, in pixels.

    calibration: None for a camera that is not calibrated; then all matrices are zero, as
    sensor_msgs/CameraInfo defines.
    """
    msg = CameraInfo(header=header, width=width, height=height)
    if calibration is not None:
        msg.width, msg.height = calibration.width, calibration.height
        msg.distortion_model = calibration.distortion_model
        msg.D, msg.K = list(calibration.distortion), list(calibration.camera_matrix)
        msg.R, msg.P = list(calibration.rectification), list(calibration.projection)
    return msg


def info_from_msg(msg: CameraInfo, camera_name: str) -> Calibration:
    """Return the calibration in a message."""
    return Calibration(camera_name, msg.width, msg.height, msg.distortion_model, tuple(msg.D),
                       tuple(msg.K), tuple(msg.R), tuple(msg.P))
