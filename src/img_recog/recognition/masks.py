"""Binary masks of color ranges, computed with few operations on few pixels."""
from typing import NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.candidates import CELL, GROUP, GROUP_PX, MIN_SAVED, Search, padded
from img_recog.recognition.mask_plan import MaskPlan, tests
from img_recog.recognition.settings import Color

# Pixels that are processed at a time, so that the intermediate arrays stay in the CPU cache. In a
# large image more of them, because each strip costs as much Python.
_MIN_STRIP_PX, _MAX_STRIP_PX, _STRIPS = 1 << 17, 1 << 18, 8
_FRAMES_WITHOUT_SEARCH = 15     # after a search that saved too little
# of the groups of an image: to copy more of them takes longer than to copy the whole image
_MAX_SHARE_INSIDE = 0.1


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
    converted and tested, and their results are put into a mask when it is asked for. A color that
    holds every pixel needs no test.
    """

    def __init__(self, shape: Tuple[int, int], colors: Sequence[Color]):
        self.shape = height, width = shape
        self.areas_px = [0] * len(colors)
        self._tested = [number for number, color in enumerate(colors) if list(tests(color))]
        tested = [colors[number] for number in self._tested]
        size_px = max(_MIN_STRIP_PX, min(height * width // _STRIPS, _MAX_STRIP_PX))
        rows = max(GROUP_PX, size_px // max(1, width) // GROUP_PX * GROUP_PX)   # whole groups
        tops = range(0, height if width and tested else 0, rows)
        self._strips = [slice(top, min(height, top + rows)) for top in tops]
        flat = [np.zeros(padded(height * width), np.uint8) for _ in colors]
        self._masks = [mask[:height * width].reshape(shape) for mask in flat]
        self._mask_groups = [mask.view(GROUP) for mask in flat]
        self._is_written = [False] * len(colors)
        strip_px = min(rows, height) * width
        self._tester = _Tester(padded(max(size_px, strip_px)), tested)
        self._groups = _Groups(height * width, self._tester, len(tested))
        self._search = Search(strip_px, tested)
        self._is_searching, self._frames_without_search = False, 0

    def compute(self, image: np.ndarray, conversion: int) -> None:
        """Compute the masks of an image.

        image: uint8 of shape (height, width, 3 or 4).
        conversion: the code for cv2.cvtColor that converts it to HSV.
        """
        self._is_searching = (bool(self._tested) and self._search.is_useful
                              and self._frames_without_search == 0)
        self._frames_without_search = max(0, self._frames_without_search - 1)
        self._groups.clear()
        self._is_written = [False] * len(self._masks)
        self.areas_px = [0 if number in self._tested else mask.size
                         for number, mask in enumerate(self._masks)]
        for strip in self._strips:
            if self._is_searching:
                groups = self._search.find(image[strip])
                self._groups.add(self._search, groups, strip.start * self.shape[1] // GROUP_PX,
                                 conversion)
            else:
                self._test_all(image, strip, conversion)
        if self._is_searching:
            self._groups.test(conversion)
            for number, area_px in zip(self._tested, self._groups.areas_px):
                self.areas_px[number] = area_px
            if self._groups.count * GROUP_PX > (1 - MIN_SAVED) * self._masks[0].size:
                self._frames_without_search = _FRAMES_WITHOUT_SEARCH

    def mask(self, number: int) -> np.ndarray:
        """Return the mask of a color: uint8 of the shape of the images, 255 inside, else 0.

        It may be changed, and lasts until the next image.
        """
        if not self._is_written[number]:
            self._is_written[number] = True
            if number not in self._tested:
                self._masks[number].fill(255)
            elif self._is_searching:
                self._groups.put(self._tested.index(number), self._mask_groups[number])
        return self._masks[number]

    def groups_inside(self, number: int) -> Optional[GroupsInside]:
        """Return the groups with pixels of a color; None if they are many, or not known."""
        if not self._is_searching or number not in self._tested:
            return None
        return self._groups.inside(self._tested.index(number))

    def _test_all(self, image: np.ndarray, strip: slice, conversion: int) -> None:
        masks = [self._masks[number][strip] for number in self._tested]
        self._tester.test(image[strip], conversion, masks)
        for number, mask in zip(self._tested, masks):
            self.areas_px[number] += cv2.countNonZero(mask)


class _Tester:
    """Tests which pixels are inside the ranges of colors."""

    def __init__(self, max_px: int, colors: Sequence[Color]):
        self._plan = MaskPlan(colors)
        self.max_px = max_px
        self._hsv = np.empty(3 * max_px, np.uint8)
        self._buffers = [np.empty(max_px, np.uint8) for _ in range(self._plan.buffers)]

    def test(self, image: np.ndarray, conversion: int, masks: Sequence[np.ndarray]) -> None:
        """Write 255 to the mask of each color where a pixel is inside, else 0.

        image: uint8 of shape (rows, columns, 3 or 4) with at most `max_px` pixels.
        masks: uint8 of shape (rows, columns).
        """
        shape, size_px = image.shape[:2], image.shape[0] * image.shape[1]
        hsv = self._hsv[:3 * size_px].reshape(shape + (3,))
        cv2.cvtColor(image, conversion, dst=hsv)
        self._plan.run([hsv, *(buffer[:size_px].reshape(shape) for buffer in self._buffers),
                        *masks])


class _Groups:
    """Tests groups of pixels and keeps the results.

    count: the number of groups; areas_px: for each color, the number of pixels inside the range.
    """

    def __init__(self, image_px: int, tester: _Tester, colors: int):
        self._tester, self._image_px = tester, image_px
        size_px = padded(image_px)
        self.count, self.areas_px = 0, [0] * colors
        self._tested = 0                # of the groups
        self._indices = np.empty(size_px // GROUP_PX, np.intp)
        self._results = [np.empty(size_px, np.uint8) for _ in range(colors)]
        self._channels = [np.empty(tester.max_px, np.uint8) for _ in range(3)]
        self._image = np.empty(3 * size_px, np.uint8)       # all pixels of the groups, bgr8

    def clear(self) -> None:
        """Forget all groups."""
        self.count, self._tested, self.areas_px = 0, 0, [0] * len(self.areas_px)

    def add(self, search: Search, groups: np.ndarray, first: int, conversion: int) -> None:
        """Add groups of the strip that was searched last.

        first: the index in the image of the strip's first group.
        """
        while len(groups):
            held = self.count - self._tested
            part = groups[:self._tester.max_px // GROUP_PX - held]
            groups = groups[len(part):]
            search.take(part, [channel.view(GROUP)[held:held + len(part)]
                               for channel in self._channels])
            np.add(part, first, out=self._indices[self.count:self.count + len(part)])
            self.count += len(part)
            if len(groups):
                self.test(conversion)

    def test(self, conversion: int) -> None:
        """Test the groups that are not tested yet."""
        first, last = self._tested * GROUP_PX, self.count * GROUP_PX
        if first == last:
            return
        row = 1, last - first
        image = self._image[3 * first:3 * last].reshape(row + (3,))
        channels = [channel[:row[1]].reshape(row) for channel in self._channels]
        if conversion == cv2.COLOR_RGB2HSV:
            channels.reverse()
        cv2.merge(channels, image)
        results = [result[first:last].reshape(row) for result in self._results]
        self._tester.test(image, cv2.COLOR_BGR2HSV, results)
        beyond = (self._indices[self.count - 1] + 1) * GROUP_PX - self._image_px
        for number, result in enumerate(results):
            if beyond > 0:
                result[:, -beyond:] = 0
            self.areas_px[number] += cv2.countNonZero(result)
        self._tested = self.count

    def inside(self, color: int) -> Optional[GroupsInside]:
        """Return the groups with pixels of a color; None if they are many."""
        if not self.areas_px[color]:
            return _NOTHING_INSIDE
        results = self._results[color].view(GROUP)[:self.count]
        nonzero, = results.nonzero()
        if len(nonzero) > _MAX_SHARE_INSIDE * len(self._indices):
            return None
        pixels = self._image.view(CELL)[nonzero].view(np.uint8).reshape(1, -1, 3)
        mask = results[nonzero].view(np.uint8).reshape(1, -1)
        return GroupsInside(self._indices[nonzero],
                            cv2.copyTo(pixels, mask).reshape(-1).view(CELL))

    def put(self, color: int, mask: np.ndarray) -> None:
        """Write the mask of a color: of type GROUP, one for each group of the image."""
        mask.fill(0)
        mask[self._indices[:self.count]] = self._results[color].view(GROUP)[:self.count]
