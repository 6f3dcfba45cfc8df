"""Images and folders of images."""
import os
from typing import List, Optional

import cv2
import numpy as np

from img_recog import still_images
from img_recog.camera.source import (FrameSkipped, FrameSource, SourceEnded, SourceError,
                                     SourceTooLarge, convert)
from img_recog.errors import one_line
from img_recog.still_images import DEFAULT_MAX_PIXELS, ImageTooLarge

# Only these are opened in a folder: another file may be a pipe, which blocks on open.
EXTENSIONS = ('.bmp', '.jpeg', '.jpg', '.pbm', '.pgm', '.png', '.pnm', '.ppm', '.tif', '.tiff',
              '.webp')

_JPEG_VIDEOS = ('.mjpeg', '.mjpg')
_START_OF_SCAN = 0xda       # a marker of JPEG


class ImageSource(FrameSource):
    """An image that is repeated."""

    def __init__(self, path: str, image: np.ndarray, rate_hz: float):
        """Repeat `image`, rgb8, which was read from `path` and becomes read-only."""
        self.name, self._image = path, image
        self._image.setflags(write=False)
        self.height, self.width = image.shape[:2]
        self.rate_hz = self.expected_hz = rate_hz
        self.description = 'image {}, {}x{}, {:g} Hz'.format(
            path, self.width, self.height, rate_hz)

    def read(self) -> np.ndarray:
        return self._image


class FolderSource(FrameSource):
    """The images of a folder in the order of their names, once or in a loop.

    Images that do not have the size of the first one are skipped.
    """

    def __init__(self, path: str, rate_hz: float, loop: bool = True,
                 max_pixels: int = DEFAULT_MAX_PIXELS):
        """Open a folder; skip images of more than `max_pixels` pixels."""
        self.name, self._loop, self._max_pixels = path, loop, max_pixels
        self._paths = image_paths(path)
        first = self._first_image()
        self.height, self.width = first.shape[:2]
        self.rate_hz = self.expected_hz = rate_hz
        self._next_index = self._good_count = 0
        self.description = 'folder {} of {} images, {}x{}, {:g} Hz, played {}'.format(
            path, len(self._paths), self.width, self.height, rate_hz,
            'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        if self._next_index == len(self._paths):
            if not self._loop:
                raise SourceEnded('the folder {} has ended after {} images'.format(
                    self.name, self._good_count))
            if self._good_count == 0:
                raise SourceError('{} can no longer be read: emptied or replaced while it played'
                                  .format(self.name))
            self._next_index = self._good_count = 0
        path = self._paths[self._next_index]
        self._next_index += 1
        try:
            image = read_image(path, self._max_pixels)
        except SourceTooLarge as error:
            raise FrameSkipped(str(error))
        if image is None:
            raise FrameSkipped('cannot read the image {}'.format(path))
        if image.shape[:2] != (self.height, self.width):
            raise FrameSkipped('image {} is {}x{} in a folder of {}x{}'.format(
                path, image.shape[1], image.shape[0], self.width, self.height))
        self._good_count += 1
        return convert(image, self.encoding)

    def _first_image(self) -> np.ndarray:
        refused = SourceError(
            'cannot open {}: neither a device nor a file, nor a folder with images'.format(
                self.name), 'set video_device to one, or to synthetic')
        for path in self._paths:
            try:
                image = read_image(path, self._max_pixels)
            except SourceTooLarge as error:
                refused = error
                continue
            if image is not None:
                return image
        raise refused


def image_paths(folder: str) -> List[str]:
    """Return the paths of the images in a folder, in the order of their names.

    Raises SourceError when the folder cannot be read.
    """
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise SourceError('cannot read {}: {}'.format(folder, one_line(error).lower()))
    paths = (os.path.join(folder, name) for name in names
             if name.lower().endswith(EXTENSIONS) and not name.startswith('.'))
    return [path for path in paths if os.path.isfile(path)]


def is_jpeg_video(path: str) -> bool:
    """Return whether a file is named as JPEG images one after the other, without a container.

    An image reader would read the first one.
    """
    return path.lower().endswith(_JPEG_VIDEOS)


def is_image(path: str) -> bool:
    """Return whether a file begins like an image of OpenCV, which may not be able to decode it."""
    try:
        return cv2.haveImageReader(path)
    except cv2.error:       # OpenEXR, which is switched off
        return True


def read_image(path: str, max_pixels: int = DEFAULT_MAX_PIXELS) -> Optional[np.ndarray]:
    """Return an image file as bgr8, or None when it cannot be read or is truncated.

    Raises SourceTooLarge for an image of more than `max_pixels` pixels.
    """
    try:
        if is_jpeg_video(path) or not is_image(path) or is_truncated(path):
            return None
        return still_images.read(path, max_pixels)
    except ImageTooLarge as error:
        raise SourceTooLarge('cannot read {}: {}'.format(path, error.problem), error.advice)
    except cv2.error:       # damaged
        return None


def is_truncated(path: str) -> bool:
    """Return whether a file is a JPEG without its end, where OpenCV would fill in grey.

    The markers are those of ITU-T T.81, annex B: segments with a length, up to the scan. Within
    the scan FF D9 can only be the end of the image; before it there may be that of a thumbnail.
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
                return False        # damaged in another way: left to OpenCV
            file.seek(length - 2, os.SEEK_CUR)
            if marker[1] == _START_OF_SCAN:
                return b'\xff\xd9' not in file.read()
