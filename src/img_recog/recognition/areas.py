"""Colour ranges to areas, masks and masked images."""
from typing import Dict, List, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.settings import Color, RecognitionSettings

_TO_HSV = {'bgr8': cv2.COLOR_BGR2HSV, 'bgra8': cv2.COLOR_BGR2HSV,
           'rgb8': cv2.COLOR_RGB2HSV, 'rgba8': cv2.COLOR_RGB2HSV}
_TO_BGR = {'bgra8': cv2.COLOR_BGRA2BGR, 'rgb8': cv2.COLOR_RGB2BGR, 'rgba8': cv2.COLOR_RGBA2BGR}
ENCODINGS = tuple(_TO_HSV)
_TOPS = (180, 255, 255)         # no H, S or V is above
# so many pixels at a time: what a strip of a large image needs then stays in the cache
_STRIP_PX = 1 << 18


class ColorExtractor:
    """Measures colours in images, in memory that is kept from image to image.

    What it returns is of the image measured last, and is overwritten by the next; nothing of that
    image may change before. The ranges are independent: a pixel may belong to several.

    A range is a test of each plane of the HSV image and the conjunction of these, which takes
    less than cv2.inRange on three channels, and equal tests of two colours are one.
    """

    def __init__(self, settings: RecognitionSettings):
        self._buffers: Dict[object, np.ndarray] = {}
        self._image: Optional[np.ndarray] = None
        self._encoding = 'bgr8'
        self._bgr: Optional[np.ndarray] = None
        self._region = (slice(0), slice(0))
        self._areas: List[int] = []
        self._masks: List[np.ndarray] = []
        self._plan: Optional[_Plan] = None
        self.use(settings)

    def use(self, settings: RecognitionSettings) -> None:
        """Measure by these settings from the next image on."""
        self._settings, self._colors, self._plan = settings, settings.colors, None

    def measure(self, image: np.ndarray, encoding: str = 'bgr8') -> List[int]:
        """Return the number of pixels of each colour, in the order of the settings.

        image: uint8 of shape (height, width, 3 or 4), whose rows may be apart in memory.
        encoding: one of ENCODINGS, the order of its channels.
        """
        self._image, self._encoding, self._bgr = image, encoding, None
        self._region = self._settings.region(image.shape[:2])
        part = image[self._region]
        if self._plan is None or self._plan.shape != part.shape[:2]:
            self._plan = _Plan(part.shape[:2], self._colors)
        self._masks, self._areas = self._plan.masks, [0] * len(self._colors)
        if part.size:
            self._plan.carry_out(part, _TO_HSV[encoding])
            if self._settings.min_blob_size > 1:
                self._drop_small_blobs()
            self._areas = [cv2.countNonZero(mask) for mask in self._masks]
        return list(self._areas)

    def mask(self, number: int) -> np.ndarray:
        """Return where colour `number` is: uint8 of shape (height, width), 255 inside, else 0."""
        whole = self._buffer('whole mask', self._image.shape[:2])
        whole[:] = 0
        whole[self._region] = self._masks[number]
        return whole

    def masked(self, number: int, result: Optional[np.ndarray] = None) -> np.ndarray:
        """Return the image in bgr8, uint8 of shape (height, width, 3), black but for a colour.

        result: where to write it, if not into kept memory.
        """
        image = self.bgr()
        if result is None:
            result = self._buffer(('masked', number), image.shape)
        result[:] = 0
        if self._areas[number]:
            cv2.copyTo(image[self._region], self._masks[number], result[self._region])
        return result

    def bgr(self) -> np.ndarray:
        """Return the image in bgr8, uint8 of shape (height, width, 3)."""
        if self._bgr is None:
            conversion, self._bgr = _TO_BGR.get(self._encoding), self._image
            if conversion is not None:
                self._bgr = self._buffer('bgr', self._image.shape[:2] + (3,))
                cv2.cvtColor(self._image, conversion, dst=self._bgr)
        return self._bgr

    def centroid(self, number: int) -> Optional[Tuple[float, float]]:
        """Return the mean x and y of a colour's pixels, None if there are none.

        In pixels of the whole image: 0, 0 is the centre of the upper left one.
        """
        area = self._areas[number]
        if area == 0:
            return None
        # most of a mask is empty, as a rule
        x, y, width, height = cv2.boundingRect(self._masks[number])
        moments = cv2.moments(self._masks[number][y:y + height, x:x + width], binaryImage=True)
        rows, columns = self._region
        return columns.start + x + moments['m10'] / area, rows.start + y + moments['m01'] / area

    def _drop_small_blobs(self) -> None:
        for mask in self._masks:
            _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
            large = stats[:, cv2.CC_STAT_AREA] >= self._settings.min_blob_size
            large[0] = False        # the background
            np.take(np.where(large, 255, 0).astype(np.uint8), labels, out=mask)

    def _buffer(self, key: object, shape: tuple) -> np.ndarray:
        """Return kept memory of a shape, whatever it holds."""
        buffer = self._buffers.get(key)
        if buffer is None or buffer.shape != shape:
            buffer = self._buffers[key] = np.empty(shape, np.uint8)
        return buffer


class _Plan:
    """The calls of OpenCV that make masks of images of one shape, strip by strip.

    They are found out once: between calls that take some microseconds, Python's own work counts.
    masks: for each colour, uint8 of the shape of the images, 255 inside, else 0.
    """

    def __init__(self, shape: Tuple[int, int], colors: Sequence[Color]):
        self.shape, self._colors = shape, colors
        self.masks = [np.zeros(shape, np.uint8) for _ in colors]
        height, width = shape
        rows = max(1, min(height, _STRIP_PX // max(1, width)))
        self._hsv = np.empty((rows, width, 3), np.uint8)
        self._planes = [np.empty((rows, width), np.uint8) for _ in range(3)]
        self._results: List[np.ndarray] = []
        self._strips = []
        for top in range(0, height if width else 0, rows):
            bottom = min(height, top + rows)
            self._strips.append((slice(top, bottom), self._hsv[:bottom - top],
                                 self._calls(top, bottom)))

    def carry_out(self, image: np.ndarray, conversion: int) -> None:
        """Write the masks of an image; conversion: that of cv2.cvtColor to HSV."""
        for rows, hsv, calls in self._strips:
            cv2.cvtColor(image[rows], conversion, hsv)
            for function, arguments in calls:
                function(*arguments)

    def _calls(self, top: int, bottom: int) -> list:
        rows = bottom - top
        planes = [plane[:rows] for plane in self._planes]
        calls, known = [(cv2.split, (self._hsv[:rows], planes))], {}
        for color, mask in zip(self._colors, self.masks):
            tests = []
            for channel, (low, high) in enumerate((color.hue, color.saturation, color.value)):
                if low > 0 or high < _TOPS[channel]:
                    key = channel, low, high
                    if key not in known:
                        known[key] = self._result(len(known))[:rows]
                        calls += _test(planes[channel], low, high, _TOPS[channel], known[key])
                    tests.append(known[key])
            calls += _conjunction(tests, mask[top:bottom])
        return calls

    def _result(self, number: int) -> np.ndarray:
        if number == len(self._results):
            self._results.append(np.empty_like(self._planes[0]))
        return self._results[number]


def _test(plane: np.ndarray, low: int, high: int, top: int, result: np.ndarray) -> list:
    """Return the calls that write where a plane is from low to high, both included.

    If low > high, it is where the plane is not between them. top: no value is above.
    """
    if low > high:
        return [(cv2.inRange, (plane, high + 1, low - 1, result)),
                (cv2.bitwise_not, (result, result))]
    if low <= 0:
        return [(cv2.threshold, (plane, high, 255, cv2.THRESH_BINARY_INV, result))]
    if high >= top:
        return [(cv2.threshold, (plane, low - 1, 255, cv2.THRESH_BINARY, result))]
    return [(cv2.inRange, (plane, low, high, result))]


def _conjunction(tests: Sequence[np.ndarray], result: np.ndarray) -> list:
    """Return the calls that write where all tests hold."""
    if not tests:
        return [(result.fill, (255,))]
    if len(tests) == 1:
        return [(np.copyto, (result, tests[0]))]
    return [(cv2.bitwise_and, (tests[0], tests[1], result)),
            *((cv2.bitwise_and, (result, test, result)) for test in tests[2:])]
