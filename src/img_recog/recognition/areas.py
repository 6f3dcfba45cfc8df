"""Areas, masks, masked images and centroids of colors."""
from typing import Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

import cv2
import numpy as np

from img_recog.recognition.candidates import CELL, GROUP, GROUP_PX, MIN_SAVED, Search, padded
from img_recog.recognition.recognition_settings import Color, RecognitionSettings

# Pixels that are processed at a time, so that the intermediate arrays stay in the CPU cache. In a
# large image more of them, because each strip costs as much Python: 640x480 are two strips.
_MIN_STRIP_PX, _MAX_STRIP_PX, _STRIPS = 160000, 1 << 18, 8
_FRAMES_WITHOUT_SEARCH = 15     # after a search that saved too little
# of the groups of an image: to copy more of them takes longer than to copy the whole image
_MAX_SHARE_INSIDE = 0.1
_TO_HSV = {'bgr8': cv2.COLOR_BGR2HSV, 'bgra8': cv2.COLOR_BGR2HSV,
           'rgb8': cv2.COLOR_RGB2HSV, 'rgba8': cv2.COLOR_RGB2HSV}
_TO_BGR = {'bgra8': cv2.COLOR_BGRA2BGR, 'rgb8': cv2.COLOR_RGB2BGR, 'rgba8': cv2.COLOR_RGBA2BGR}
ENCODINGS = tuple(_TO_HSV)
_WHOLE = (0.0, 1.0)
_BLACK = np.zeros(1, CELL)


class GroupsInside(NamedTuple):
    """The groups of an image in which pixels of a color are.

    indices: of the groups; bgr: the groups in bgr8, of type CELL, with all other pixels black.
    """

    indices: np.ndarray
    bgr: np.ndarray


_NOTHING_INSIDE = GroupsInside(np.empty(0, np.intp), np.empty(0, CELL))


class Masks:
    """Computes the masks of images of one shape, in reused buffers.

    areas_px: for each color, the number of pixels inside the range.

    The conversion to HSV takes most of the time, so only the groups of pixels that need it are
    converted and tested, and their results are put into a mask when it is asked for. Without
    strips, a frame of a film takes 6 % more CPU time at 1920x1080 if its images are viewed, and
    20 % if not.
    """

    def __init__(self, shape: Tuple[int, int], colors: Sequence[Color]):
        self.shape = height, width = shape
        self.areas_px = [0] * len(colors)
        size_px = max(_MIN_STRIP_PX, min(height * width // _STRIPS, _MAX_STRIP_PX))
        rows = max(GROUP_PX, size_px // max(1, width) // GROUP_PX * GROUP_PX)   # whole groups
        self._strips = [slice(top, min(height, top + rows))
                        for top in range(0, height if width else 0, rows)]
        flat = [np.zeros(padded(height * width), np.uint8) for _ in colors]
        self._masks = [mask[:height * width].reshape(shape) for mask in flat]
        self._mask_groups = [mask.view(GROUP) for mask in flat]
        self._is_written = [False] * len(colors)
        rows = min(rows, height)
        self._tester = _Tester(padded(max(size_px, rows * width)), colors)
        self._groups = _Groups(height * width, self._tester, len(colors))
        self._search = Search((rows, width), colors)
        self._is_searching, self._frames_without_search = False, 0

    def compute(self, image: np.ndarray, conversion: int) -> None:
        """Compute the masks of an image.

        image: uint8 of shape (height, width, 3 or 4).
        conversion: the code for cv2.cvtColor that converts it to HSV.
        """
        self._is_searching = self._search.is_useful and self._frames_without_search == 0
        self._frames_without_search = max(0, self._frames_without_search - 1)
        self.areas_px = [0] * len(self._masks)
        if not self._is_searching:
            for strip in self._strips:
                self._tester.test(image[strip], conversion, [mask[strip] for mask in self._masks],
                                  self.areas_px)
            return
        self._groups.clear()
        self._is_written = [False] * len(self._masks)
        for strip in self._strips:
            indices, channels = self._search.find(image[strip])
            if len(indices):
                if conversion == cv2.COLOR_RGB2HSV:
                    channels.reverse()
                self._groups.add(indices + strip.start * self.shape[1] // GROUP_PX, channels)
        self._groups.test()
        self.areas_px = list(self._groups.areas_px)
        if self._groups.count * GROUP_PX > (1 - MIN_SAVED) * image.shape[0] * image.shape[1]:
            self._frames_without_search = _FRAMES_WITHOUT_SEARCH

    def mask(self, number: int) -> np.ndarray:
        """Return the mask of a color: uint8 of the shape of the images, 255 inside, else 0.

        It may be changed, and lasts until the next image.
        """
        if self._is_searching and not self._is_written[number]:
            self._is_written[number] = True
            self._groups.put(number, self._mask_groups[number])
        return self._masks[number]

    def groups_inside(self, number: int) -> Optional[GroupsInside]:
        """Return the groups with pixels of a color; None if they are many, or not known.

        If whole images were drawn instead, a frame of a film whose images are viewed would take
        20 % more CPU time at 640x480 and 26 % at 1920x1080.
        """
        return self._groups.inside(number) if self._is_searching else None


class _Tester:
    """Tests which pixels are inside the ranges of colors."""

    def __init__(self, max_px: int, colors: Sequence[Color]):
        self.max_px, self._colors = max_px, colors
        self._hsv = np.empty(3 * max_px, np.uint8)
        # hue, saturation, value, and the result of a test
        self._buffers = [np.empty(max_px, np.uint8) for _ in range(4)]

    def test(self, image: np.ndarray, conversion: int, masks: Sequence[np.ndarray],
             areas_px: List[int]) -> None:
        """Write 255 to the mask of each color where a pixel is inside, else 0; add their areas.

        image: uint8 of shape (rows, columns, 3 or 4) with at most `max_px` pixels.
        masks: uint8 of shape (rows, columns).
        Tests of one channel take less time than cv2.inRange on three.
        """
        shape, size_px = image.shape[:2], image.shape[0] * image.shape[1]
        hsv = self._hsv[:3 * size_px].reshape(shape + (3,))
        cv2.cvtColor(image, conversion, dst=hsv)
        hue, saturation, value, inside = (buffer[:size_px].reshape(shape)
                                          for buffer in self._buffers)
        cv2.split(hsv, [hue, saturation, value])
        for number, (color, mask) in enumerate(zip(self._colors, masks)):
            low, high = color.hue
            if low <= high:
                cv2.inRange(hue, low, high, mask)
            else:       # it wraps around
                cv2.inRange(hue, high + 1, low - 1, mask)
                cv2.bitwise_not(mask, mask)
            for plane, (low, high) in ((saturation, color.saturation), (value, color.value)):
                cv2.inRange(plane, low, high, inside)
                cv2.bitwise_and(mask, inside, mask)
            areas_px[number] += cv2.countNonZero(mask)


class _Groups:
    """Tests groups of pixels and keeps the results.

    count: the number of groups; areas_px: for each color, the number of pixels inside the range.
    """

    def __init__(self, image_px: int, tester: _Tester, colors: int):
        self._tester, self._image_px = tester, image_px
        size_px = padded(image_px)
        self.count, self.areas_px = 0, [0] * colors
        self._indices = np.empty(size_px // GROUP_PX, np.intp)
        self._results = [np.empty((1, size_px), np.uint8) for _ in range(colors)]
        self._image = np.empty((1, size_px, 3), np.uint8)       # all pixels of the groups, bgr8

    def clear(self) -> None:
        """Forget all groups."""
        self.count, self.areas_px = 0, [0] * len(self.areas_px)

    def add(self, indices: np.ndarray, channels: Sequence[np.ndarray]) -> None:
        """Add groups of the image, with blue, green and red of their pixels."""
        start, self.count = self.count, self.count + len(indices)
        self._indices[start:self.count] = indices
        cv2.merge(channels, self._image[:, start * GROUP_PX:self.count * GROUP_PX])

    def test(self) -> None:
        """Test all groups."""
        if not self.count:
            return
        # the last group may have pixels after the last row of the image
        end = self.count * GROUP_PX - max(
            0, (int(self._indices[self.count - 1]) + 1) * GROUP_PX - self._image_px)
        for start in range(0, end, self._tester.max_px):
            part = slice(start, min(end, start + self._tester.max_px))
            self._tester.test(self._image[:, part], cv2.COLOR_BGR2HSV,
                              [result[:, part] for result in self._results], self.areas_px)
        for result in self._results:
            result[:, end:self.count * GROUP_PX] = 0

    def inside(self, color: int) -> Optional[GroupsInside]:
        """Return the groups with pixels of a color; None if they are many."""
        if not self.areas_px[color]:
            return _NOTHING_INSIDE
        results = self._results[color][0].view(GROUP)[:self.count]
        nonzero, = results.nonzero()
        if len(nonzero) > _MAX_SHARE_INSIDE * len(self._indices):
            return None
        pixels = self._image.reshape(-1).view(CELL)[nonzero].view(np.uint8).reshape(1, -1, 3)
        mask = results[nonzero].view(np.uint8).reshape(1, -1)
        return GroupsInside(self._indices[nonzero],
                            cv2.copyTo(pixels, mask).reshape(-1).view(CELL))

    def put(self, color: int, mask: np.ndarray) -> None:
        """Write the mask of a color: of type GROUP, one for each group of the image."""
        mask.fill(0)
        mask[self._indices[:self.count]] = self._results[color][0].view(GROUP)[:self.count]


def bgr_copy(image: np.ndarray, encoding: str) -> np.ndarray:
    """Return a new image in bgr8, uint8 of shape (height, width, 3); encoding: of ENCODINGS."""
    conversion = _TO_BGR.get(encoding)
    return image.copy() if conversion is None else cv2.cvtColor(image, conversion)


def to_hsv(image: np.ndarray, encoding: str) -> np.ndarray:
    """Return an image on OpenCV's 8-bit HSV scale, as `bgr_copy` does in bgr8."""
    return cv2.cvtColor(np.ascontiguousarray(image), _TO_HSV[encoding])


class ColorExtractor:
    """Measures the colors of images, in buffers that are reused for the next image.

    All results are those of the last measured image. They are overwritten by the next call of
    `measure`, and the image must not be changed before it. The ranges are independent: a pixel
    may belong to several colors.
    """

    def __init__(self, settings: RecognitionSettings):
        self._buffers: Dict[object, np.ndarray] = {}
        self._image = np.zeros((0, 0, 3), np.uint8)
        self._encoding = 'bgr8'
        self._bgr: Optional[np.ndarray] = None
        self._region = (slice(0), slice(0))
        self._areas_px: List[int] = []
        self._masks, self._settings = Masks((0, 0), settings.colors), settings
        self._changed: Set[int] = set()     # colors whose masks have less than their groups
        self.configure(settings)

    def configure(self, settings: RecognitionSettings) -> None:
        """Use other settings from the next image on."""
        self._next_settings = settings

    def measure(self, image: np.ndarray, encoding: str = 'bgr8') -> List[int]:
        """Return the area of each color in pixels, in the order of the settings.

        image: uint8 of shape (height, width, 3 or 4); its rows need not be contiguous.
        encoding: one of ENCODINGS, the order of its channels.
        """
        self._image, self._encoding, self._bgr = image, encoding, None
        height, width = image.shape[:2]
        is_new, self._settings = self._next_settings is not self._settings, self._next_settings
        self._region = self._settings.region((height, width))
        part = image[self._region]
        height, width = part.shape[:2]
        if is_new or self._masks.shape != (height, width):
            self._masks = Masks((height, width), self._settings.colors)
        self._masks.compute(part, _TO_HSV[encoding])
        self._areas_px = list(self._masks.areas_px)
        self._changed.clear()
        self._drop_outside()
        if self._settings.min_blob_size > 1 and 0 not in self._masks.shape:
            self._drop_small_blobs()
        return list(self._areas_px)

    @property
    def shape(self) -> Tuple[int, int, int]:
        """The shape of `bgr` and `masked`."""
        height, width = self._image.shape[:2]
        return height, width, 3

    def mask(self, number: int) -> np.ndarray:
        """Return the mask of a color: uint8 of shape (height, width), 255 inside, else 0."""
        mask = self._buffer('mask', self._image.shape[:2])
        mask[:] = 0
        mask[self._region] = self._masks.mask(number)
        return mask

    def masked(self, number: int) -> np.ndarray:
        """Return the image with all other pixels black: bgr8, uint8 of shape (height, width, 3).

        number: of the color whose pixels are kept.
        """
        result = np.empty(self.shape, np.uint8)
        self.draw_masked(number, result)
        return result

    def draw_masked(self, number: int, result: np.ndarray, drawn: Optional[np.ndarray] = None
                    ) -> Optional[np.ndarray]:
        """Write what `masked` returns to an array; return a note of where it is not black.

        result: uint8 of the shape of the image; its rows are contiguous. drawn: the note of what
        it contains, so that only this is cleared; None for arbitrary content.
        """
        groups = self._groups_inside(number)
        if groups is None or drawn is None:
            result[:] = 0
        if groups is None:
            if self._areas_px[number]:
                cv2.copyTo(self.bgr()[self._region], self._masks.mask(number),
                           result[self._region])
            return None
        cells = result.reshape(-1).view(CELL)
        if drawn is not None:
            cells[drawn] = _BLACK
        cells[groups.indices] = groups.bgr
        return groups.indices

    def _groups_inside(self, number: int) -> Optional[GroupsInside]:
        """Return what Masks.groups_inside does, if that is the whole mask and the image fits."""
        height, width = self._image.shape[:2]
        if (number in self._changed or height * width % GROUP_PX
                or self._masks.shape != (height, width)):
            return None
        return self._masks.groups_inside(number)

    def bgr(self) -> np.ndarray:
        """Return the image in bgr8, uint8 of shape (height, width, 3)."""
        if self._bgr is None:
            self._bgr = self._converted_to_bgr()
        return self._bgr

    def centroid(self, number: int) -> Optional[Tuple[float, float]]:
        """Return the mean x and y of the pixels of a color, None if there are none.

        In pixels of the whole image: (0, 0) is the center of its upper left pixel.
        """
        area_px = self._areas_px[number]
        if area_px == 0:
            return None
        # most of a mask is usually empty
        mask = self._masks.mask(number)
        x, y, width, height = cv2.boundingRect(mask)
        moments = cv2.moments(mask[y:y + height, x:x + width], binaryImage=True)
        rows, columns = self._region
        return (columns.start + x + moments['m10'] / area_px,
                rows.start + y + moments['m01'] / area_px)

    def _converted_to_bgr(self) -> np.ndarray:
        conversion = _TO_BGR.get(self._encoding)
        if conversion is None:
            return self._image
        bgr = self._buffer('bgr', self._image.shape[:2] + (3,))
        if self._image.size:        # OpenCV rejects an image without pixels
            cv2.cvtColor(self._image, conversion, dst=bgr)
        return bgr

    def _drop_outside(self) -> None:
        """Remove the pixels outside of the rows and columns of a color."""
        starts = [part.start for part in self._region]
        for number, color in enumerate(self._settings.colors):
            if (color.rows, color.columns) != (_WHOLE, _WHOLE):
                (top, bottom), (left, right) = (
                    [max(0, round(share * size) - start) for share in shares]
                    for shares, size, start in zip((color.rows, color.columns),
                                                   self._image.shape[:2], starts))
                mask = self._masks.mask(number)
                self._changed.add(number)
                mask[:top], mask[bottom:], mask[:, :left], mask[:, right:] = 0, 0, 0, 0
                self._areas_px[number] = cv2.countNonZero(mask) if mask.size else 0

    def _drop_small_blobs(self) -> None:
        smallest = self._settings.min_blob_size
        for number, area_px in enumerate(self._areas_px):
            if not area_px:
                continue
            mask = self._masks.mask(number)
            if area_px == mask.size >= smallest:
                continue        # one blob of all pixels
            x, y, width, height = cv2.boundingRect(mask)        # takes little time
            mask = mask[y:y + height, x:x + width]
            _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
            large = stats[:, cv2.CC_STAT_AREA] >= smallest
            large[0] = False        # the background
            if large[1:].all():
                continue
            self._changed.add(number)
            mask[:] = np.where(large, 255, 0).astype(np.uint8)[labels]
            self._areas_px[number] = cv2.countNonZero(mask)

    def _buffer(self, key: object, shape: Tuple[int, ...]) -> np.ndarray:
        """Return the buffer of this name and shape; its contents are undefined."""
        buffer = self._buffers.get(key)
        if buffer is None or buffer.shape != shape:
            buffer = self._buffers[key] = np.empty(shape, np.uint8)
        return buffer
