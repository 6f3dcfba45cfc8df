"""Color ranges to masks, by few operations on few pixels."""
import functools
from typing import Callable, FrozenSet, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.settings import Color

_TOPS = (180, 255, 255)         # no H, S or V is above
# so many pixels at a time: what a strip of a large image needs then stays in the cache
_STRIP_PX = 1 << 17
# a look that spares less than a quarter costs more than it spares, and is left out for a while
_WORTH, _FRAMES_WITHOUT = 0.75, 15
# the arrays of a strip: its HSV image, four planes, then results of tests, then masks
_HSV, _PLANES, _RESULTS = 0, 1, 5

_Box = Tuple[slice, slice]      # rows and columns
_Call = Callable[[Sequence[np.ndarray]], object]


class Masks:
    """Makes the masks of images of one shape, in memory that is kept.

    masks: for each color, uint8 of the shape of the images, 255 inside, else 0.
    areas_px: for each color, how many pixels are inside.

    A range is a test of each plane of the HSV image and the conjunction of these, which takes
    less than cv2.inRange on three channels, and equal tests of two colors are one. The
    conversion to HSV takes most of the time, and is made only where it is needed: what has the
    saturation of a color has channels that differ, and that is seen in a third of the time.
    """

    def __init__(self, shape: Tuple[int, int], colors: Sequence[Color]):
        self.shape = shape
        self.masks = [np.zeros(shape, np.uint8) for _ in colors]
        self.areas_px = [0] * len(colors)
        program = _Program(colors)
        line = _line_below(frozenset((color.saturation, color.value) for color in colors))
        height, width = shape
        rows = max(1, min(height, _STRIP_PX // max(1, width)))
        scratch = [np.empty((rows, width, 3), np.uint8)]
        scratch += [np.empty((rows, width), np.uint8) for _ in range(program.first_mask - 1)]
        self._strips = []
        for top in range(0, height if width else 0, rows):
            strip = slice(top, min(height, top + rows))
            arrays = [each[:strip.stop - top] for each in scratch]
            self._strips.append((strip, _Strip(
                arrays + [mask[strip] for mask in self.masks], program, line)))

    def make(self, image: np.ndarray, conversion: int) -> None:
        """Make the masks of an image; conversion: that of cv2.cvtColor to HSV."""
        areas_px = [strip.make(image[rows], conversion) for rows, strip in self._strips]
        self.areas_px = [sum(each) for each in zip(*areas_px)] or [0] * len(self.masks)


class _Strip:
    """Some rows of the masks."""

    def __init__(self, arrays: List[np.ndarray], program: '_Program', line: Optional['_Line']):
        self._arrays, self._program, self._line = arrays, program, line
        self._whole = tuple(slice(0, length) for length in arrays[_HSV].shape[:2])
        self._masks = arrays[program.first_mask:]
        self._nothing = [0] * len(self._masks)
        self._box: Optional[_Box] = None        # outside, the masks are empty
        self._parts: List[np.ndarray] = []
        self._frames_without = 0

    def make(self, image: np.ndarray, conversion: int) -> List[int]:
        """Make the masks of these rows of an image; return the areas."""
        box = self._look(image)
        if box != self._box:
            if self._box is not None:
                for mask in self._masks:
                    mask[self._box] = 0
            self._box = box
            self._parts = [] if box is None else [array[box] for array in self._arrays]
        if box is None:
            return self._nothing
        cv2.cvtColor(image[box], conversion, self._parts[_HSV])
        for call in self._program.calls:
            call(self._parts)
        return [cv2.countNonZero(part) for part in self._parts[self._program.first_mask:]]

    def _look(self, image: np.ndarray) -> Optional[_Box]:
        """Return what holds all pixels that can be of a color, None if none can."""
        if self._line is None or self._frames_without:
            self._frames_without = max(0, self._frames_without - 1)
            return self._whole
        planes = self._arrays[_PLANES:_PLANES + image.shape[2]]
        most = self._arrays[_RESULTS]
        cv2.split(image, planes)
        first, second, third = planes[:3]
        cv2.max(first, second, most)
        cv2.max(most, third, most)
        cv2.min(first, second, first)
        cv2.min(first, third, first)
        cv2.addWeighted(most, 1 - self._line.slope, first, -1, 1 - self._line.offset, first)
        left, top, width, height = cv2.boundingRect(first)
        if width * height > _WORTH * first.size:
            self._frames_without = _FRAMES_WITHOUT
        return (slice(top, top + height), slice(left, left + width)) if width else None


class _Program:
    """The calls that make masks of an HSV image, for the arrays of a strip.

    They are found out once: between calls that take some microseconds, Python's own work counts.
    """

    def __init__(self, colors: Sequence[Color]):
        self.calls: List[_Call] = [
            lambda arrays: cv2.split(arrays[_HSV], arrays[_PLANES:_PLANES + 3])]
        known, conjunctions = {}, []
        for color in colors:
            tests = []
            for channel, (low, high) in enumerate((color.hue, color.saturation, color.value)):
                if low > 0 or high < _TOPS[channel]:
                    key = channel, low, high
                    if key not in known:
                        known[key] = _RESULTS + len(known)
                        self.calls += _test(_PLANES + channel, low, high, _TOPS[channel],
                                            known[key])
                    tests.append(known[key])
            conjunctions.append(tests)
        self.first_mask = _RESULTS + max(1, len(known))
        for number, tests in enumerate(conjunctions):
            self.calls += _conjunction(tests, self.first_mask + number)


def _test(plane: int, low: int, high: int, top: int, result: int) -> List[_Call]:
    """Return the calls that write where a plane is from low to high, both included.

    If low > high, it is where the plane is not between them. top: no value is above.
    """
    if low > high:
        return [lambda arrays: cv2.inRange(arrays[plane], high + 1, low - 1, arrays[result]),
                lambda arrays: cv2.bitwise_not(arrays[result], arrays[result])]
    if low <= 0:
        return [lambda arrays: cv2.threshold(arrays[plane], high, 255, cv2.THRESH_BINARY_INV,
                                             arrays[result])]
    if high >= top:
        return [lambda arrays: cv2.threshold(arrays[plane], low - 1, 255, cv2.THRESH_BINARY,
                                             arrays[result])]
    return [lambda arrays: cv2.inRange(arrays[plane], low, high, arrays[result])]


def _conjunction(tests: Sequence[int], result: int) -> List[_Call]:
    """Return the calls that write where all tests hold."""
    if not tests:
        return [lambda arrays: arrays[result].fill(255)]
    if len(tests) == 1:
        return [lambda arrays: np.copyto(arrays[result], arrays[tests[0]])]
    calls = [lambda arrays: cv2.bitwise_and(arrays[tests[0]], arrays[tests[1]], arrays[result])]
    for test in tests[2:]:
        calls.append(lambda arrays, test=test: cv2.bitwise_and(arrays[result], arrays[test],
                                                               arrays[result]))
    return calls


class _Line(NamedTuple):
    """Chroma, the difference of the largest and the smallest channel, by value, the largest."""

    slope: float
    offset: float


@functools.lru_cache(maxsize=16)
def _line_below(ranges: FrozenSet[Tuple[Tuple[int, int], Tuple[int, int]]]) -> Optional[_Line]:
    """Return a line that no pixel of the ranges of S and V is below, None if few others are.

    Of these lines, it is the one that has the fewest pixels above it in an image of which
    1 / (1 + chroma) are of a chroma: most of what there is to see is nearly grey.
    """
    value, chroma = np.mgrid[:256, :256]
    exists = chroma <= value
    inside = np.zeros_like(exists)
    for (low_s, high_s), (low_v, high_v) in ranges:
        inside |= ((_saturations() >= low_s) & (_saturations() <= high_s)
                   & (value >= low_v) & (value <= high_v))
    inside &= exists
    share = exists / (1 + chroma)
    if not inside.any():
        return _Line(0, 256)
    lines = {}
    for slope in np.linspace(0, 1, 17):
        above = chroma - slope * value
        offset = above[inside].min()
        lines[share[above >= offset].sum()] = _Line(slope, offset)
    fewest = min(lines)
    return lines[fewest] if fewest < _WORTH * share.sum() else None


@functools.lru_cache(maxsize=None)
def _saturations() -> np.ndarray:
    """Return OpenCV's S by value and chroma, uint8 of shape (256, 256)."""
    value, chroma = np.mgrid[:256, :256]
    least = (value - chroma).clip(0)
    pixels = np.stack([value, least, least], axis=-1).astype(np.uint8)
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2HSV)[..., 1]
