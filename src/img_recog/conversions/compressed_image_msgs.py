"""sensor_msgs/CompressedImage to and from arrays, as compressed_image_transport has them."""
from dataclasses import dataclass

import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from img_recog.conversions import image_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.settings import Settings, between, one_of, setting

_PIXELS = {'mono8': (), 'bgr8': (3,), 'rgb8': (3,)}       # the shape of one
_COLOURS = ('rgb', 'bgr')


@dataclass(frozen=True)
class CompressionSettings(Settings):
    """How images are compressed: the parameters of compressed_image_transport in Noetic."""

    format: str = setting('jpeg', one_of('jpeg', 'png'), 'Compression format')
    jpeg_quality: int = setting(80, between(1, 100), 'JPEG quality percentile')
    jpeg_progressive: bool = setting(False, description='Enable compression to progressive JPEG')
    jpeg_optimize: bool = setting(False, description='Enable JPEG compress optimization')
    jpeg_restart_interval: int = setting(0, between(0, 65535), 'JPEG restart interval')
    png_level: int = setting(9, between(1, 9), 'PNG compression level')


def to_msg(image: np.ndarray, encoding: str, header: Header,
           settings: CompressionSettings = CompressionSettings()) -> CompressedImage:
    """Return a message that holds `image`, uint8 of shape (height, width[, 3]), compressed.

    encoding: rgb8, bgr8 or mono8. The format says, as compressed_image_transport does, what the
    image was and what its file holds: colors are always handed to the encoder as bgr8, and
    nothing is named for grey: 'rgb8; jpeg compressed bgr8', 'mono8; png compressed '.
    Raises ImageError when the image cannot be compressed.
    """
    try:
        if image.ndim < 2 or image.shape[2:] != _PIXELS[encoding] or image.dtype != np.uint8:
            raise ValueError('it does not fit that encoding')
        pixels = cv2.cvtColor(image, cv2.COLOR_RGB2BGR) if encoding == 'rgb8' else image
        done, data = cv2.imencode('.' + settings.format, pixels, _arguments(settings))
        if not done:
            raise ValueError('the encoder failed')
    except (cv2.error, KeyError, ValueError) as error:
        raise ImageError('cannot compress an image of shape {} and encoding {!r} as {}: {}'.format(
            image.shape, encoding, settings.format, ' '.join(str(error).split())))
    text = '{}; {} compressed {}'.format(encoding, settings.format,
                                         'bgr8' if image.ndim == 3 else '')
    return CompressedImage(header=header, data=data.tobytes(), format=text)


def from_msg(msg: CompressedImage, encoding: str = 'bgr8') -> np.ndarray:
    """Return the image of a message in the wanted encoding, whatever was compressed and how.

    Colors are where the format says that they are: a format that names a color encoding and
    then not 'compressed bgr' is of an old publisher, and its file has red and blue exchanged; one
    without a semicolon says nothing, and the file is as files are.
    Raises ImageError naming format, size and reason.
    """
    try:
        image = cv2.imdecode(np.frombuffer(msg.data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise _refusal(msg, error)
    if image is None:
        raise _refusal(msg, 'no image that OpenCV can read')
    found = _encoding_of(image, msg.format)
    if found == encoding:
        return image
    try:
        return image_msgs.from_msg(image_msgs.to_msg(image, found, msg.header), encoding)
    except ImageError as error:
        raise _refusal(msg, error)


def _arguments(settings: CompressionSettings) -> list:
    if settings.format == 'png':
        return [cv2.IMWRITE_PNG_COMPRESSION, settings.png_level]
    return [cv2.IMWRITE_JPEG_QUALITY, settings.jpeg_quality,
            cv2.IMWRITE_JPEG_PROGRESSIVE, int(settings.jpeg_progressive),
            cv2.IMWRITE_JPEG_OPTIMIZE, int(settings.jpeg_optimize),
            cv2.IMWRITE_JPEG_RST_INTERVAL, settings.jpeg_restart_interval]


def _encoding_of(image: np.ndarray, text: str) -> str:
    """Return what a decoded image is by its message's format."""
    original, separator, compressed = text.partition(';')
    bits = 8 * image.dtype.itemsize
    if image.ndim == 2:
        # what a sensor with a Bayer filter saw is compressed as if it were grey
        return original if original.startswith('bayer_') else 'mono{}'.format(bits)
    swapped = separator and original.startswith(_COLOURS) and 'compressed bgr' not in compressed
    return '{}{}{}'.format('rgb' if swapped else 'bgr', 'a' if image.shape[2] == 4 else '', bits)


def _refusal(msg: CompressedImage, reason) -> ImageError:
    return ImageError('cannot decode a compressed image of format {!r}, {} bytes: {}'.format(
        msg.format, len(msg.data), ' '.join(str(reason).split())))
