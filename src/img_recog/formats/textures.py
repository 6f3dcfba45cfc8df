"""Images of materials."""
import numpy as np
from PIL import Image

from img_recog.errors import UserError, one_line
from img_recog.files import plain

_MAX_SIZE_PX = 4096
# 8192x16384; each takes 3 bytes while it is reduced. Images of a camera have max_image_pixels
_MAX_PIXELS = 1 << 27
Image.MAX_IMAGE_PIXELS = None       # Pillow's own limit is a warning, or names no number


class TextureError(UserError):
    """A texture cannot be read."""


def read(path: str, mode: str = 'RGB') -> np.ndarray:
    """Return the image of a file, (rows, columns, channels); mode: RGB or RGBA.

    An image with a side of more than 4096 pixels is reduced. Raises TextureError naming the file.
    """
    try:
        with open(path, 'rb', opener=plain) as file, Image.open(file) as image:
            if image.width * image.height > _MAX_PIXELS:
                raise ValueError('{}x{} pixels are more than {}'.format(
                    image.width, image.height, _MAX_PIXELS))
            image.thumbnail((_MAX_SIZE_PX, _MAX_SIZE_PX))
            return np.asarray(image.convert(mode))      # which does not copy it once more
    except Exception as error:      # Pillow raises errors of many types
        raise TextureError('cannot read the texture {}: {}'.format(path, one_line(error)),
                           'give a PNG or JPEG file')
