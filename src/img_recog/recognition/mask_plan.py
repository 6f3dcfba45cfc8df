"""The tests of color ranges on HSV images, shared by several colors."""
from typing import Callable, Dict, Iterator, List, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.settings import Color

_MAX_HSV = (180, 255, 255)      # no H, S or V is larger
# indices of the arrays of a plan: an HSV image, its planes, then results of tests, then masks
_HSV, _PLANES, _RESULTS = 0, 1, 4

_Operation = Callable[[Sequence[np.ndarray]], object]


class MaskPlan:
    """The operations that compute masks from an HSV image.

    A mask is the conjunction of one test for each plane of the HSV image. This takes less time
    than cv2.inRange on three channels, and a test that two colors share runs once.

    buffers: how many arrays they need between the HSV image and the masks.

    The plan is made once: beside operations of a few microseconds, the overhead of Python counts.
    """

    def __init__(self, colors: Sequence[Color]):
        self._operations: List[_Operation] = [
            lambda arrays: cv2.split(arrays[_HSV], arrays[_PLANES:_PLANES + 3])]
        results: Dict[Tuple[int, int, int], int] = {}       # of each test: index of its array
        results_of_colors = []
        for color in colors:
            for test in tests(color):
                if test not in results:
                    results[test] = _RESULTS + len(results)
                    channel, low, high = test
                    self._operations += _test_operations(
                        _PLANES + channel, low, high, _MAX_HSV[channel], results[test])
            results_of_colors.append([results[test] for test in tests(color)])
        first_mask = _RESULTS + len(results)
        self.buffers = first_mask - _PLANES
        for number, color_results in enumerate(results_of_colors):
            self._operations += _conjunction_operations(color_results, first_mask + number)

    def run(self, arrays: Sequence[np.ndarray]) -> None:
        """Compute the masks.

        arrays: uint8 of shape (rows, columns): the HSV image, which has three channels, then
        `buffers` others with arbitrary content, then the masks.
        """
        for operation in self._operations:
            operation(arrays)


def tests(color: Color) -> Iterator[Tuple[int, int, int]]:
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
