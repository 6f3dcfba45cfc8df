"""Images and folders of images."""
import os
from typing import Callable, List, Optional, Tuple

import cv2
import numpy as np

from img_recog.camera.source import (FrameSkipped, FrameSource, SourceEnded, SourceError,
                                     SourceTooLarge, convert)
from img_recog.errors import counted, one_line, shortened
from img_recog.formats import still_images
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS, ImageTooLarge

# A file of another name is an image by its content; one of these is, even if it is damaged.
EXTENSIONS = ('.bmp', '.j2k', '.jp2', '.jpeg', '.jpg', '.pbm', '.pgm', '.png', '.pnm', '.ppm',
              '.ras', '.sr', '.tif', '.tiff', '.webp')
# The same of videos. Cameras have live streams of the second names, too.
VIDEO_EXTENSIONS = ('.3gp', '.avi', '.f4v', '.m2ts', '.m4v', '.mkv', '.mov', '.mp4', '.mpeg',
                    '.mpg', '.mts', '.mxf', '.nut', '.ogv', '.vob', '.webm', '.wmv', '.y4m')
VIDEO_OR_LIVE_EXTENSIONS = '.asf', '.flv'

UNREADABLE = 'cannot read the image {}: it is damaged, or of a kind that OpenCV does not read'
_JPEG_VIDEOS = ('.mjpeg', '.mjpg')
_START_OF_SCAN = 0xda       # a marker of JPEG


class ImageSource(FrameSource):
    """An image that is repeated."""

    expected_frames = 1

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
    """The images of a folder in the order of their names.

    Images that do not have the size of the first one are skipped.
    """

    def __init__(self, path: str, rate_hz: float, loop: bool = True,
                 max_pixels: int = DEFAULT_MAX_PIXELS,
                 warn: Callable[[str], None] = lambda _: None):
        """Open a folder; skip images of more than `max_pixels` pixels.

        warn: called with a line if there is anything else in it.
        """
        self.name, self.loops, self._max_pixels = path, loop, max_pixels
        self._paths, left_out = files_in(path, is_image)
        self.expected_frames = len(self._paths)
        first = self._first_image(left_out)
        if left_out:
            warn(left_out)
        self.height, self.width = first.shape[:2]
        self.rate_hz = self.expected_hz = rate_hz
        self._next_index = self._good_count = 0
        self.description = 'folder {} of {}, {}x{}, {:g} Hz, played {}'.format(
            path, counted(len(self._paths), 'image'), self.width, self.height, rate_hz,
            'in a loop' if loop else 'once')

    def read(self) -> np.ndarray:
        if self._next_index == len(self._paths):
            raise SourceEnded('the folder {} has ended after {} images'.format(
                self.name, self._good_count))
        path = self._paths[self._next_index]
        self._next_index += 1
        try:
            image = read_image(path, self._max_pixels)
        except SourceTooLarge as error:
            raise FrameSkipped(str(error))
        if image is None:
            raise FrameSkipped(UNREADABLE.format(path))
        if image.shape[:2] != (self.height, self.width):
            raise FrameSkipped('image {} is {}x{} in a folder of {}x{}'.format(
                path, image.shape[1], image.shape[0], self.width, self.height))
        self._good_count += 1
        return convert(image, self.encoding)

    def _first_image(self, left_out: str) -> np.ndarray:
        refused = SourceError(
            'cannot open {}: there is no image in it that can be read{}'.format(
                self.name, left_out and '; ' + left_out),
            'give a folder with images, or synthetic')
        for path in self._paths:
            try:
                image = read_image(path, self._max_pixels)
            except SourceTooLarge as error:
                refused = error
                continue
            if image is not None:
                return image
        raise refused


def files_in(folder: str, is_wanted: Callable[[str], bool]) -> Tuple[List[str], str]:
    """Return paths in a folder, in the order of their names, and in a line what is left out.

    is_wanted: whether to return the path of a file. The line is empty if nothing is left out but
    hidden files. Raises SourceError when the folder cannot be read.
    """
    try:
        names = sorted(name for name in os.listdir(folder) if not name.startswith('.'))
    except OSError as error:
        raise SourceError('cannot read {}: {}'.format(folder, one_line(error).lower()))
    # another file may be a pipe, which blocks on open
    found = [name for name in names if os.path.isfile(os.path.join(folder, name))
             and is_wanted(os.path.join(folder, name))]
    others = sorted(set(names).difference(found))
    return [os.path.join(folder, name) for name in found], (
        '{} of {} entries of the folder {} left out: {}'.format(
            len(others), len(names), folder, shortened(', '.join(others))) if others else '')


def is_image(path: str) -> bool:
    """Return whether a file is a still image that OpenCV reads, by its name or its content."""
    return not is_jpeg_video(path) and (
        path.lower().endswith(EXTENSIONS) or has_reader(path))


def has_reader(path: str, switched_off: bool = False) -> bool:
    """Return whether a file is a still image by its content.

    switched_off: what is returned of a format that OpenCV knows and refuses to read: OpenEXR.
    """
    try:
        return cv2.haveImageReader(path)
    except cv2.error:
        return switched_off


def is_jpeg_video(path: str) -> bool:
    """Return whether a file is named as JPEG images one after the other, without a container.

    An image reader would read the first one.
    """
    return path.lower().endswith(_JPEG_VIDEOS)


def read_image(path: str, max_pixels: int = DEFAULT_MAX_PIXELS) -> Optional[np.ndarray]:
    """Return an image file as bgr8, or None when it cannot be read or is truncated.

    Raises SourceTooLarge for an image of more than `max_pixels` pixels.
    """
    try:
        if is_jpeg_video(path) or not has_reader(path) or is_truncated(path):
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
