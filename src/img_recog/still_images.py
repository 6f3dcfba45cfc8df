"""Decodes still images up to a number of pixels: a file of 131 kB can hold 1.6 billion of them.

Pillow reads the size from the header, which takes 0.01 to 0.1 ms and no memory, so that the error
can name it. OpenCV decodes; its own limit is read when it is loaded and does not name the size, so
it is only the second wall, for a header that both libraries read differently.
"""
import argparse
import io
from typing import IO, Optional, Tuple, Union

import cv2
import numpy as np

from img_recog.errors import UserError
from img_recog.settings import between

DEFAULT_MAX_PIXELS = 50000000
# the upper end is OPENCV_IO_MAX_IMAGE_PIXELS, as __init__.py of the package sets it
ALLOWED_MAX_PIXELS = between(1, 1 << 28)


class ImageTooLarge(UserError):
    """An image or a video has more pixels than are allowed."""


def check_size(width: float, height: float, max_pixels: int) -> None:
    """Raise ImageTooLarge if an image of this size, in pixels, must not be decoded."""
    if width * height > max_pixels:
        raise ImageTooLarge('{:.0f}x{:.0f} are {:.0f} pixels, more than max_image_pixels = {}'
                            .format(width, height, width * height, max_pixels),
                            'set max_image_pixels to allow it')


def decode(data: bytes, flags: int, max_pixels: int) -> Optional[np.ndarray]:
    """Return the image in `data`, None if it is no image whose size is known.

    flags: of cv2.imdecode.
    Raises ImageTooLarge, and cv2.error like OpenCV.
    """
    size = _size(io.BytesIO(data))
    if size is None:
        return None
    check_size(*size, max_pixels)
    return cv2.imdecode(np.frombuffer(data, np.uint8), flags)


def read(path: str, flags: int, max_pixels: int) -> Optional[np.ndarray]:
    """Return the image in the file `path`, None if it is no image whose size is known.

    flags: of cv2.imread.
    Raises ImageTooLarge, and cv2.error like OpenCV.
    """
    size = _size(path)
    if size is None:
        return None
    check_size(*size, max_pixels)
    return cv2.imread(path, flags)


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


def _size(file: Union[str, IO[bytes]]) -> Optional[Tuple[int, int]]:
    """Return width and height as the header states them, None if Pillow does not know them."""
    from PIL import Image  # takes 40 ms, which a video does not need
    Image.MAX_IMAGE_PIXELS = None       # it would warn, or fail, before the size is known
    try:
        with Image.open(file) as image:
            return image.size
    # its many readers raise nearly everything for damaged headers; MemoryError: WebP's canvas
    except Exception:
        return None
