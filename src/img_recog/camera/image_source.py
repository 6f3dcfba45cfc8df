"""images and folders of them, by OpenCV."""
import os
from typing import Optional

import cv2
import numpy as np

from img_recog.camera.pixels import converted
from img_recog.camera.source import FrameSkipped, FrameSource, SourceEnded, SourceError

# Only these are looked at in a folder: others may be anything, and block whoever opens them.
EXTENSIONS = ('.bmp', '.jpeg', '.jpg', '.pbm', '.pgm', '.png', '.pnm', '.ppm', '.tif', '.tiff',
              '.webp')

_SCAN = 0xda        # the marker SOS of a JPEG


class ImageSource(FrameSource):
    """A image, repeated."""

    def __init__(self, path: str, image: np.ndarray, rate_hz: float):
        """Repeat `image`, rgb8 and of `path`, which it keeps."""
        self.name, self._image = path, image
        self._image.setflags(write=False)
        self.height, self.width = image.shape[:2]
        self.rate_hz = self.expected_hz = rate_hz
        self.description = 'image {}, {}x{}, {:g} Hz'.format(
            path, self.width, self.height, rate_hz)

    def read(self) -> np.ndarray:
        return self._image


class FolderSource(FrameSource):
    """The images of a folder by the order of their names, once or in a loop.

    All have the size of the first; others are skipped.
    """

    def __init__(self, path: str, rate_hz: float, loop: bool = True):
        self.name, self._loop = path, loop
        self._paths = image_paths(path)
        first = next(filter(lambda image: image is not None, map(read_image, self._paths)), None)
        if first is None:
            raise SourceError(
                'cannot open {}: neither a device nor a file, nor a folder with images; set '
                'video_device to one, or to synthetic'.format(path))
        self.height, self.width = first.shape[:2]
        self.rate_hz = self.expected_hz = rate_hz
        self._number = self._good = 0
        self.description = 'folder {} of {} images, {}x{}, {:g} Hz, played {}'.format(
            path, len(self._paths), self.width, self.height, rate_hz,
            'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        if self._number == len(self._paths):
            if not self._loop:
                raise SourceEnded('the folder {} is over after {} images'.format(
                    self.name, self._good))
            if self._good == 0:
                raise SourceError('{} can no longer be read: emptied or replaced while it played'
                                  .format(self.name))
            self._number = self._good = 0
        path = self._paths[self._number]
        self._number += 1
        image = read_image(path)
        if image is None:
            raise FrameSkipped('cannot read the image {}'.format(path))
        if image.shape[:2] != (self.height, self.width):
            raise FrameSkipped('image {} is {}x{} in a folder of {}x{}'.format(
                path, image.shape[1], image.shape[0], self.width, self.height))
        self._good += 1
        return converted(image, self.encoding)


def image_paths(folder: str) -> list:
    """Return the images in a folder by the order of their names.

    Raises SourceError when the folder cannot be read.
    """
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise SourceError('cannot read {}: {}'.format(folder, error.strerror.lower()))
    paths = (os.path.join(folder, name) for name in names
             if name.lower().endswith(EXTENSIONS) and not name.startswith('.'))
    return [path for path in paths if os.path.isfile(path)]


def read_image(path: str) -> Optional[np.ndarray]:
    """Return an image file as bgr8, None when OpenCV cannot read it or it is cut off."""
    try:
        if not cv2.haveImageReader(path) or is_truncated(path):
            return None
        return cv2.imread(path, cv2.IMREAD_COLOR)
    except cv2.error:       # its header claims more pixels than OpenCV allows
        return None


def is_truncated(path: str) -> bool:
    """Return whether a file is a JPEG without its end, which OpenCV would fill up with grey.

    Markers as in ITU-T T.81, annex B: segments of a length each, up to the scan. In that no FF D9
    stands but the end; before it may be those of a thumbnail.
    """
    with open(path, 'rb') as file:
        if file.read(3) != b'\xff\xd8\xff':
            return False
        file.seek(2)
        while True:
            marker = file.read(2)
            while marker == b'\xff\xff':        # fill bytes
                marker = b'\xff' + file.read(1)
            if len(marker) < 2:
                return True
            length = int.from_bytes(file.read(2), 'big')
            if marker[0] != 0xff or length < 2:
                return False        # damaged in another way, which OpenCV is to judge
            file.seek(length - 2, os.SEEK_CUR)
            if marker[1] == _SCAN:
                return b'\xff\xd9' not in file.read()
