"""Decodes still images up to a number of pixels: a file of 131 kB can hold 1.6 billion of them.

Pillow reads the format and the size from the header, which takes 0.01 to 0.1 ms and no memory, so
that the error can name them. OpenCV decodes the formats whose header it reads like Pillow. TIFF
and JPEG 2000 can be written so that two libraries see two sizes: Pillow decodes them too, and Sun
raster, which OpenCV does not read if it is packed. OpenCV's own limit is read when it is loaded
and does not name the size, so it is only the second wall.
"""
import argparse
import contextlib
import functools
import io
import os
import struct
import warnings
import zlib
from typing import IO, Any, Callable, Iterator, Optional, Union

import cv2
import numpy as np

from img_recog.errors import UserError
from img_recog.settings import between

DEFAULT_MAX_PIXELS = 50000000
# the upper end is OPENCV_IO_MAX_IMAGE_PIXELS, as __init__.py of the package sets it
ALLOWED_MAX_PIXELS = between(1, 1 << 28)
# by their names in Pillow; MPO is a JPEG with further images behind the first
_MESSAGE_FORMATS = ('JPEG', 'MPO', 'PNG')
_OPENCV_FORMATS = ('BMP', 'JPEG', 'MPO', 'PNG', 'PPM', 'WEBP')
_PILLOW_FORMATS = ('GIF', 'JPEG2000', 'SUN', 'TIFF')
_MAX_JPEG2000_BOXES = 1 << 20    # bytes before the codestream: a color profile, metadata
_PNG_SIGNATURE_BYTES, _PNG_CHECKSUM_BYTES = 8, 4
_ORIENTATION = 0x112        # tag of EXIF: where the first row and column are (Exif 2.3, 4.6.4)
# whether an image is transposed, then how cv2.flip mirrors it
_TURNS = {2: (False, 1), 3: (False, -1), 4: (False, 0), 5: (True, None), 6: (True, 1),
          7: (True, -1), 8: (True, 0)}
_PNG_CHUNK = struct.Struct('>I4s')      # length and type, before its data and the checksum


class ImageTooLarge(UserError):
    """An image or a video has more pixels than are allowed."""


class ImageFormatError(UserError):
    """An image has a format that is not allowed where it came from."""


def check_size(width: float, height: float, max_pixels: float) -> None:
    """Raise ImageTooLarge if an image of this size, in pixels, must not be decoded."""
    if width * height > max_pixels:
        raise ImageTooLarge('{:.0f}x{:.0f} are {:.0f} pixels, more than max_image_pixels = {}'
                            .format(width, height, width * height, max_pixels),
                            'set max_image_pixels to allow it')


def decode(data: bytes, max_pixels: int) -> Optional[np.ndarray]:
    """Return the JPEG or PNG in `data` as it is; None if it is damaged or of no known format.

    Raises ImageTooLarge, ImageFormatError for another format, and cv2.error like OpenCV.
    """
    with _opened(io.BytesIO(data)) as image:
        if image is None:
            return None
        if image.format not in _MESSAGE_FORMATS:
            raise ImageFormatError('it is {}, allowed are JPEG and PNG'.format(image.format))
        check_size(image.size[0], image.size[1], max_pixels)
        return _by_opencv(image, lambda: cv2.imdecode(np.frombuffer(data, np.uint8),
                                                      cv2.IMREAD_UNCHANGED))


def read(path: str, max_pixels: int) -> Optional[np.ndarray]:
    """Return the image in the file `path` as bgr8; None if it is damaged or of no known format.

    Raises ImageTooLarge, and cv2.error like OpenCV.
    """
    with _opened(path) as image:
        if image is None:
            return None
        check_size(image.size[0], image.size[1], max_pixels)
        if image.format in _OPENCV_FORMATS:
            # OpenCV 4.11 does not read the EXIF data of a WebP
            is_webp = image.format == 'WEBP'
            flags = cv2.IMREAD_COLOR | (cv2.IMREAD_IGNORE_ORIENTATION if is_webp else 0)
            decoded = _by_opencv(image, lambda: cv2.imread(path, flags))
            return _upright(decoded, image) if is_webp else decoded
        return _by_pillow(image) if image.format in _PILLOW_FORMATS else None


def count(path: str) -> int:
    """Return how many images the file `path` has: of an animation, or the pages of a TIFF.

    1 for a JPEG with a preview or a depth map behind it (MPO), and for a file that is damaged.
    """
    with _opened(path) as image:
        if image is None or image.format == 'MPO':
            return 1
        try:
            return getattr(image, 'n_frames', 1)
        except Exception:       # as in _opened
            return 1


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add the option --max-image-pixels to the command line of a tool."""
    parser.add_argument('--max-image-pixels', type=_max_pixels, metavar='N',
                        default=DEFAULT_MAX_PIXELS, help='largest image or video that is read, '
                        'in pixels (default: %(default)s)')


def _max_pixels(text: str) -> int:
    if not (text.isdecimal() and ALLOWED_MAX_PIXELS.accepts(int(text))):
        raise argparse.ArgumentTypeError('got {!r}, expected a whole number {}'.format(
            text, ALLOWED_MAX_PIXELS.text))
    return int(text)


@functools.lru_cache(maxsize=None)
def pillow() -> Any:
    """Return the module PIL.Image, set up to give neither limits nor warnings of its own."""
    from PIL import Image  # takes 40 ms, which a video does not need
    Image.MAX_IMAGE_PIXELS = None       # it would warn, or fail, before the size is known
    warnings.filterwarnings('ignore', category=UserWarning, module='PIL')
    return Image


@contextlib.contextmanager
def _opened(file: Union[str, IO[bytes]]) -> Iterator[Any]:
    """Open an image, of which only the header is read; give None if Pillow does not know it."""
    try:
        image = pillow().open(file)
    # its many readers raise nearly everything for damaged headers; MemoryError: WebP's canvas
    except Exception:
        yield None
        return
    with image:
        yield image


def _is_whole_png(file: IO[bytes]) -> bool:
    """Return whether no chunk of a PNG ends after the file, or is damaged and needed.

    OpenCV 4.11 allocates the length that a chunk states, 2 GB at most, before it reads it. libpng
    prints a line for a wrong checksum.
    """
    size, position = file.seek(0, os.SEEK_END), _PNG_SIGNATURE_BYTES
    while position + _PNG_CHUNK.size <= size:
        file.seek(position)
        length, kind = _PNG_CHUNK.unpack(file.read(_PNG_CHUNK.size))
        if kind == b'IEND':
            return True
        position += _PNG_CHUNK.size + length + _PNG_CHECKSUM_BYTES
        if position > size:
            return False
        if kind[:1].isupper() and zlib.crc32(file.read(length), zlib.crc32(
                kind)) != int.from_bytes(file.read(_PNG_CHECKSUM_BYTES), 'big'):
            return False
    return True


def _by_opencv(header: Any, decode_it: Callable[[], Any]) -> Optional[np.ndarray]:
    """Return the image that OpenCV decodes, None unless it has the size of its header.

    header: the image as opened by Pillow.
    OpenCV turns an image as its EXIF data say, so width and height may be exchanged.
    """
    if header.format == 'PNG' and not _is_whole_png(header.fp):
        return None
    image = decode_it()
    if image is None or sorted(image.shape[:2]) != sorted(header.size):
        return None
    return image


def _upright(decoded: Optional[np.ndarray], image: Any) -> Optional[np.ndarray]:
    """Return the pixels of an opened image, turned as its EXIF data say."""
    try:
        orientation = image.getexif().get(_ORIENTATION)
    except Exception:       # as in _opened
        return decoded
    if decoded is None or orientation not in _TURNS:
        return decoded
    is_transposed, flip = _TURNS[orientation]
    decoded = cv2.transpose(decoded) if is_transposed else decoded
    return decoded if flip is None else cv2.flip(decoded, flip)


def _by_pillow(image: Any) -> Optional[np.ndarray]:
    """Return an opened image as bgr8, without alpha and turned as its EXIF data say.

    None if it is damaged, or has 32 bits per channel, which OpenCV does not read as color either,
    or if it is a JPEG 2000 in color with more than 8 bits, where white may become black.
    """
    try:
        if image.format == 'JPEG2000' and image.mode != 'I;16' and _jpeg2000_bits(image) > 8:
            return None
        image.load()
        if image.mode.startswith('I;16'):
            return cv2.cvtColor((np.asarray(image) >> 8).astype(np.uint8), cv2.COLOR_GRAY2BGR)
        if image.mode in ('F', 'I'):
            return None
        return cv2.cvtColor(np.asarray(image.convert('RGB')), cv2.COLOR_RGB2BGR)
    except Exception:       # as in _opened
        return None


def _jpeg2000_bits(image: Any) -> int:
    """Return the bits of the first channel of a JPEG 2000, by the marker SIZ of its codestream."""
    image.fp.seek(0)
    start = image.fp.read(_MAX_JPEG2000_BOXES)
    return (start[start.index(b'\xff\x4f\xff\x51') + 42] & 0x7f) + 1
