"""Binary masks of color ranges, computed with few operations on few pixels."""
import functools
from typing import Callable, Dict, FrozenSet, Iterator, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.settings import Color

_MAX_HSV = (180, 255, 255)      # no H, S or V is larger
# pixels that are processed at a time, so that the intermediate arrays stay in the CPU cache
_STRIP_PX = 1 << 17
# a search that saves less than a quarter of the pixels costs more than it saves, so the next
# frames are processed without one
_MAX_BOX_SHARE, _FRAMES_WITHOUT_SEARCH = 0.75, 15
# indices of the arrays of a strip: its HSV image, four planes, then results of tests, then masks
_HSV, _PLANES, _RESULTS = 0, 1, 5

_Box = Tuple[slice, slice]      # rows and columns
_Operation = Callable[[Sequence[np.ndarray]], object]


class Masks:
    """Computes the masks of images of one shape, in reused buffers.

    masks: for each color, uint8 of the shape of the images, 255 inside the range, else 0.
    areas_px: for each color, the number of pixels inside the range.

    A mask is the conjunction of one test for each plane of the HSV image. This takes less time
    than cv2.inRange on three channels, and a test that two colors share runs once. The conversion
    to HSV takes most of the time, so only the pixels that need it are converted: a pixel with the
    saturation of a color has different values in its channels, and finding those pixels takes a
    third of the time of the conversion. A color that holds every pixel needs no conversion.
    """

    def __init__(self, shape: Tuple[int, int], colors: Sequence[Color]):
        self.shape = shape
        self.masks = [np.zeros(shape, np.uint8) for _ in colors]
        self.areas_px = [0] * len(colors)
        self._tested = [number for number, color in enumerate(colors) if list(_tests(color))]
        self._full = [number for number in range(len(colors)) if number not in self._tested]
        tested = [colors[number] for number in self._tested]
        tested_masks = [self.masks[number] for number in self._tested]
        plan = MaskPlan(tested)
        bound = _chroma_bound(frozenset((color.saturation, color.value) for color in tested))
        height, width = shape
        rows = max(1, min(height, _STRIP_PX // max(1, width)))
        scratch = [np.empty((rows, width, 3), np.uint8)]
        scratch += [np.empty((rows, width), np.uint8) for _ in range(plan.first_mask - 1)]
        self._strips = []
        for top in range(0, height if width and tested else 0, rows):
            strip = slice(top, min(height, top + rows))
            arrays = [array[:strip.stop - top] for array in scratch]
            self._strips.append((strip, _MaskStrip(
                arrays + [mask[strip] for mask in tested_masks], plan, bound)))

    def compute(self, image: np.ndarray, conversion: int) -> None:
        """Compute the masks of an image.

        image: uint8 of shape (height, width, 3 or 4).
        conversion: the code for cv2.cvtColor that converts it to HSV.
        """
        strip_areas_px = [strip.compute(image[rows], conversion) for rows, strip in self._strips]
        for number, areas_px in zip(self._tested, zip(*strip_areas_px)):
            self.areas_px[number] = sum(areas_px)
        for number in self._full:
            self.masks[number].fill(255)
            self.areas_px[number] = self.masks[number].size


class _MaskStrip:
    """Some rows of the masks."""

    def __init__(self, arrays: List[np.ndarray], plan: 'MaskPlan',
                 bound: Optional['ChromaBound']):
        self._arrays, self._plan, self._bound = arrays, plan, bound
        height, width = arrays[_HSV].shape[:2]
        self._whole = slice(0, height), slice(0, width)
        self._masks = arrays[plan.first_mask:]
        self._no_areas_px = [0] * len(self._masks)
        self._box: Optional[_Box] = None        # outside it, the masks are zero
        self._boxed_arrays: List[np.ndarray] = []
        self._frames_without_search = 0

    def compute(self, image: np.ndarray, conversion: int) -> List[int]:
        """Compute the masks of these rows of an image; return the areas."""
        box = self._candidate_box(image)
        if box != self._box:
            if self._box is not None:
                for mask in self._masks:
                    mask[self._box] = 0
            self._box = box
            self._boxed_arrays = [] if box is None else [array[box] for array in self._arrays]
        if box is None:
            return self._no_areas_px
        cv2.cvtColor(image[box], conversion, self._boxed_arrays[_HSV])
        for operation in self._plan.operations:
            operation(self._boxed_arrays)
        return [cv2.countNonZero(mask) for mask in self._boxed_arrays[self._plan.first_mask:]]

    def _candidate_box(self, image: np.ndarray) -> Optional[_Box]:
        """Return a box around all pixels that can be inside a range, None if there are none."""
        if self._bound is None or self._frames_without_search:
            self._frames_without_search = max(0, self._frames_without_search - 1)
            return self._whole
        planes = self._arrays[_PLANES:_PLANES + image.shape[2]]
        largest = self._arrays[_RESULTS]
        cv2.split(image, planes)
        first, second, third = planes[:3]
        cv2.max(first, second, largest)
        cv2.max(largest, third, largest)
        cv2.min(first, second, first)
        cv2.min(first, third, first)
        # nonzero where chroma = largest - smallest channel is on or above the bound
        cv2.addWeighted(largest, 1 - self._bound.slope, first, -1, 1 - self._bound.offset, first)
        left, top, width, height = cv2.boundingRect(first)
        if width * height > _MAX_BOX_SHARE * first.size:
            self._frames_without_search = _FRAMES_WITHOUT_SEARCH
        return (slice(top, top + height), slice(left, left + width)) if width else None


class MaskPlan:
    """The operations that compute masks from an HSV image, on the arrays of a strip.

    operations: to be called in order; first_mask: index of the first mask in the arrays.

    The plan is made once: beside operations of a few microseconds, the overhead of Python counts.
    """

    def __init__(self, colors: Sequence[Color]):
        self.operations: List[_Operation] = [
            lambda arrays: cv2.split(arrays[_HSV], arrays[_PLANES:_PLANES + 3])]
        results: Dict[Tuple[int, int, int], int] = {}       # of each test: index of its array
        results_of_colors = []
        for color in colors:
            for test in _tests(color):
                if test not in results:
                    results[test] = _RESULTS + len(results)
                    channel, low, high = test
                    self.operations += _test_operations(
                        _PLANES + channel, low, high, _MAX_HSV[channel], results[test])
            results_of_colors.append([results[test] for test in _tests(color)])
        self.first_mask = _RESULTS + max(1, len(results))
        for number, color_results in enumerate(results_of_colors):
            self.operations += _conjunction_operations(color_results, self.first_mask + number)


def _tests(color: Color) -> Iterator[Tuple[int, int, int]]:
    """Yield the channel and its lowest and highest value for each test that a color needs."""
    for channel, (low, high) in enumerate((color.hue, color.saturation, color.value)):
        if low > 0 or high < _MAX_HSV[channel]:
            yield channel, low, high


def _test_operations(plane: int, low: int, high: int, max_value: int,
                     result: int) -> List[_Operation]:
    """Return the operations that test whether a plane is from low to high, both included.

    If low > high, the test is whether the plane is outside of the values between them.
    max_value: the largest value that the plane can have.
    """
    if low > high:
        return [lambda arrays: cv2.inRange(arrays[plane], high + 1, low - 1, arrays[result]),
                lambda arrays: cv2.bitwise_not(arrays[result], arrays[result])]
    if low <= 0:
        return [lambda arrays: cv2.threshold(arrays[plane], high, 255, cv2.THRESH_BINARY_INV,
                                             arrays[result])]
    if high >= max_value:
        return [lambda arrays: cv2.threshold(arrays[plane], low - 1, 255, cv2.THRESH_BINARY,
                                             arrays[result])]
    return [lambda arrays: cv2.inRange(arrays[plane], low, high, arrays[result])]


def _conjunction_operations(inputs: Sequence[int], result: int) -> List[_Operation]:
    """Return the operations that compute where the results of all tests are nonzero."""
    if len(inputs) == 1:
        return [lambda arrays: np.copyto(arrays[result], arrays[inputs[0]])]
    return [_and_operation(inputs[0], inputs[1], result),
            *(_and_operation(result, test, result) for test in inputs[2:])]


def _and_operation(first: int, second: int, result: int) -> _Operation:
    return lambda arrays: cv2.bitwise_and(arrays[first], arrays[second], arrays[result])


class ChromaBound(NamedTuple):
    """A line in the plane of value and chroma: chroma = slope * value + offset.

    value: the largest channel of a pixel; chroma: the largest channel minus the smallest.
    """

    slope: float
    offset: float


@functools.lru_cache(maxsize=16)
def _chroma_bound(
        ranges: FrozenSet[Tuple[Tuple[int, int], Tuple[int, int]]]) -> Optional[ChromaBound]:
    """Return a bound that no pixel in the ranges of S and V is below.

    It is the one with the fewest pixels above it in a typical image, in which 1 / (1 + chroma) of
    the pixels have a chroma: most pixels are nearly grey. None if too few pixels are below it.
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
        return ChromaBound(0, 256)
    bounds = {}
    for slope in np.linspace(0, 1, 17):
        height = chroma - slope * value
        offset = height[inside].min()
        bounds[share[height >= offset].sum()] = ChromaBound(slope, offset)
    smallest_share = min(bounds)
    return bounds[smallest_share] if smallest_share < _MAX_BOX_SHARE * share.sum() else None


@functools.lru_cache(maxsize=None)
def _saturations() -> np.ndarray:
    """Return OpenCV's S by value and chroma, uint8 of shape (256, 256)."""
    value, chroma = np.mgrid[:256, :256]
    smallest = (value - chroma).clip(0)
    pixels = np.stack([value, smallest, smallest], axis=-1).astype(np.uint8)
    return cv2.cvtColor(pixels, cv2.COLOR_RGB2HSV)[..., 1]
