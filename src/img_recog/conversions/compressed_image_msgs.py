"""Conversion of sensor_msgs/CompressedImage to and from arrays.

The messages are like those of compressed_image_transport.
"""
from dataclasses import dataclass
from typing import ClassVar, List

import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from img_recog.conversions import image_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.errors import one_line, shortened
from img_recog.formats import still_images
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS, ImageFormatError, ImageTooLarge
from img_recog.settings import Settings, clamped, one_of, setting

_PIXEL_SHAPES = {'mono8': (), 'bgr8': (3,), 'rgb8': (3,)}
_COLOR_PREFIXES = ('rgb', 'bgr')
_FORMATS = one_of('jpeg', 'png')


@dataclass(frozen=True)
class CompressionSettings(Settings):
    """How images are compressed: the parameters of compressed_image_transport in Noetic.

    As there, each number becomes the nearest allowed one, and with another format than jpeg and
    png, no image can be compressed.
    """

    is_like_roscpp: ClassVar[bool] = True
    format: str = setting('jpeg', _FORMATS._replace(accepts=lambda _: True), 'Compression format')
    jpeg_quality: int = setting(80, clamped(1, 100), 'JPEG quality percentile')
    jpeg_progressive: bool = setting(False, description='Enable compression to progressive JPEG')
    jpeg_optimize: bool = setting(False, description='Enable JPEG compress optimization')
    jpeg_restart_interval: int = setting(0, clamped(0, 65535), 'JPEG restart interval')
    png_level: int = setting(9, clamped(1, 9), 'PNG compression level')


def to_msg(image: np.ndarray, encoding: str, header: Header,
           settings: CompressionSettings = CompressionSettings()) -> CompressedImage:
    """Return the compressed message for `image`, of shape (height, width[, channels]).

    encoding: that of the array, as in sensor_msgs/image_encodings.h, of 8 or 16 bits.
    The field format has the encodings of the image and of the compressed data, like that of
    compressed_image_transport: color is always compressed as bgr8, or with 16 bits in PNG as
    bgr16, and all else has no second encoding: 'rgb8; jpeg compressed bgr8', 'mono8; png
    compressed '.
    Raises ImageError when the image cannot be compressed.

    >>> to_msg(np.zeros((2, 4, 3), np.uint8), 'rgb8', Header()).format
    'rgb8; jpeg compressed bgr8'
    """
    try:
        if not _FORMATS.accepts(settings.format):
            raise ValueError('the format has to be {}'.format(_FORMATS.text))
        if image.dtype.itemsize > 2:
            raise ValueError('its values have more than 16 bits')
        bits = 8 * image.dtype.itemsize if settings.format == 'png' else 8
        target = 'bgr{}'.format(bits) if encoding.startswith(_COLOR_PREFIXES) else ''
        pixels = _converted(image, encoding, target)
        encoded, data = cv2.imencode('.' + settings.format, pixels, _encoder_flags(settings))
        if not encoded:
            raise ValueError('the encoder failed')
    except (cv2.error, ImageError, ValueError) as error:
        raise ImageError('cannot compress an image of shape {} and encoding {} as {}: {}'.format(
            image.shape, shortened(repr(encoding)), shortened(settings.format), one_line(error)))
    text = '{}; {} compressed {}'.format(encoding, settings.format, target)
    return CompressedImage(header=header, data=data.tobytes(), format=text)


def _converted(image: np.ndarray, encoding: str, target: str) -> np.ndarray:
    """Return an image in the encoding `target`, as it is if that is empty."""
    if encoding not in _PIXEL_SHAPES:       # rare, and needs cv_bridge
        return image_msgs.from_msg(image_msgs.to_msg(image, encoding, Header()),
                                   target or 'passthrough')
    if image.ndim < 2 or image.shape[2:] != _PIXEL_SHAPES[encoding] or image.dtype != np.uint8:
        raise ValueError('it does not have the shape or type of that encoding')
    return cv2.cvtColor(image, cv2.COLOR_RGB2BGR) if encoding == 'rgb8' else image


def from_msg(msg: CompressedImage, max_pixels: int = DEFAULT_MAX_PIXELS) -> np.ndarray:
    """Return the image of a message in bgr8.

    The order of the colors follows the field format: with a color encoding but without
    'compressed bgr', the message is from an old publisher, which swapped red and blue in the
    compressed data. A format without a semicolon has no such information: nothing is swapped.
    Raises ImageError naming the format, size and reason, also for more than `max_pixels` pixels
    and for data that are neither JPEG nor PNG, whatever the field format says.
    """
    try:
        image = still_images.decode(msg.data, max_pixels)
    except (cv2.error, ImageFormatError, ImageTooLarge) as error:
        raise _image_error(msg, error)
    if image is None:
        raise _image_error(msg, 'no image that OpenCV can read')
    decoded = _encoding_of(image, msg.format)
    if decoded == 'bgr8':
        return image
    try:
        return image_msgs.from_msg(image_msgs.to_msg(image, decoded, msg.header), 'bgr8')
    except ImageError as error:
        raise _image_error(msg, error)


def _encoder_flags(settings: CompressionSettings) -> List[int]:
    if settings.format == 'png':
        return [cv2.IMWRITE_PNG_COMPRESSION, settings.png_level]
    return [cv2.IMWRITE_JPEG_QUALITY, settings.jpeg_quality,
            cv2.IMWRITE_JPEG_PROGRESSIVE, int(settings.jpeg_progressive),
            cv2.IMWRITE_JPEG_OPTIMIZE, int(settings.jpeg_optimize),
            cv2.IMWRITE_JPEG_RST_INTERVAL, settings.jpeg_restart_interval]


def _encoding_of(image: np.ndarray, msg_format: str) -> str:
    """Return the encoding of a decoded image, given the field format of its message."""
    original, separator, compressed = msg_format.partition(';')
    bits = 8 * image.dtype.itemsize
    if image.ndim == 2:
        # a Bayer image is compressed as if it were grey
        return original if original.startswith('bayer_') else 'mono{}'.format(bits)
    swapped = (separator and original.startswith(_COLOR_PREFIXES)
               and 'compressed bgr' not in compressed)
    return '{}{}{}'.format('rgb' if swapped else 'bgr', 'a' if image.shape[2] == 4 else '', bits)


def _image_error(msg: CompressedImage, reason: object) -> ImageError:
    return ImageError('cannot decode a compressed image of format {}, {} bytes: {}'.format(
        shortened(repr(msg.format)), len(msg.data), one_line(reason)))
