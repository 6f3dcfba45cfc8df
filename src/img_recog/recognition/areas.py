"""Colour ranges to areas, masks and masked images."""
from typing import Dict, List, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.settings import RecognitionSettings

_TO_HSV = {'bgr8': cv2.COLOR_BGR2HSV, 'bgra8': cv2.COLOR_BGR2HSV,
           'rgb8': cv2.COLOR_RGB2HSV, 'rgba8': cv2.COLOR_RGB2HSV}
_TO_BGR = {'bgra8': cv2.COLOR_BGRA2BGR, 'rgb8': cv2.COLOR_RGB2BGR, 'rgba8': cv2.COLOR_RGBA2BGR}
ENCODINGS = tuple(_TO_HSV)
_TOPS = (180, 255, 255)         # no H, S or V is above
# so many pixels at a time: what a strip of a large image needs then stays in the cache
_STRIP_PX = 1 << 19


class ColorExtractor:
    """Measures colours in images, in memory that is kept from image to image.

    What it returns is of the image measured last, and is overwritten by the next; nothing of that
    image may change before. The ranges are independent: a pixel may belong to several.

    A range is a test of each plane of the HSV image and the conjunction of these, which takes
    less than cv2.inRange on three channels, and equal tests of two colours are one.
    """

    def __init__(self, settings: RecognitionSettings):
        self.use(settings)
        self._buffers: Dict[object, np.ndarray] = {}
        self._image: Optional[np.ndarray] = None
        self._encoding = 'bgr8'
        self._bgr: Optional[np.ndarray] = None
        self._region = (slice(0), slice(0))
        self._areas: List[int] = []
        self._masks: List[np.ndarray] = []

    def use(self, settings: RecognitionSettings) -> None:
        """Measure by these settings from the next image on."""
        self._settings, self._colors = settings, settings.colors

    def measure(self, image: np.ndarray, encoding: str = 'bgr8') -> List[int]:
        """Return the number of pixels of each colour, in the order of the settings.

        image: uint8 of shape (height, width, 3 or 4), whose rows may be apart in memory.
        encoding: one of ENCODINGS, the order of its channels.
        """
        self._image, self._encoding, self._bgr = image, encoding, None
        self._region = self._settings.region(image.shape[:2])
        part = image[self._region]
        self._masks = [self._buffer(('mask', number), part.shape[:2])
                       for number in range(len(self._colors))]
        self._areas = [0] * len(self._colors)
        if part.size:
            rows = max(1, _STRIP_PX // part.shape[1])
            for top in range(0, len(part), rows):
                self._measure_strip(part[top:top + rows], slice(top, top + rows))
            if self._settings.min_blob_size > 1:
                self._drop_small_blobs()
        return list(self._areas)

    def mask(self, number: int) -> np.ndarray:
        """Return where colour `number` is: uint8 of shape (height, width), 255 inside, else 0."""
        whole = self._buffer('whole mask', self._image.shape[:2])
        whole[:] = 0
        whole[self._region] = self._masks[number]
        return whole

    def masked(self, number: int) -> np.ndarray:
        """Return the image in bgr8, uint8 of shape (height, width, 3), black but for a colour."""
        image = self.bgr()
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
        moments = cv2.moments(self._masks[number], binaryImage=True)
        rows, columns = self._region
        return columns.start + moments['m10'] / area, rows.start + moments['m01'] / area

    def _measure_strip(self, strip: np.ndarray, rows: slice) -> None:
        hsv = self._buffer('hsv', strip.shape[:2] + (3,))
        cv2.cvtColor(strip, _TO_HSV[self._encoding], dst=hsv)
        planes = [self._buffer(('plane', channel), strip.shape[:2]) for channel in range(3)]
        cv2.split(hsv, planes)
        known: Dict[tuple, np.ndarray] = {}
        for number, color in enumerate(self._colors):
            mask = self._masks[number][rows]
            tests = []
            for channel, (low, high) in enumerate((color.hue, color.saturation, color.value)):
                if low > 0 or high < _TOPS[channel]:
                    key = channel, low, high
                    if key not in known:
                        known[key] = self._buffer(('test', len(known)), strip.shape[:2])
                        _test(planes[channel], low, high, _TOPS[channel], known[key])
                    tests.append(known[key])
            _conjunction(tests, mask)
            self._areas[number] += cv2.countNonZero(mask)

    def _drop_small_blobs(self) -> None:
        for number, mask in enumerate(self._masks):
            _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
            large = stats[:, cv2.CC_STAT_AREA] >= self._settings.min_blob_size
            large[0] = False        # the background
            np.take(np.where(large, 255, 0).astype(np.uint8), labels, out=mask)
            self._areas[number] = cv2.countNonZero(mask)

    def _buffer(self, key: object, shape: tuple) -> np.ndarray:
        """Return kept memory of a shape, whatever it holds."""
        buffer = self._buffers.get(key)
        if buffer is None or buffer.shape[1:] != shape[1:] or len(buffer) < shape[0]:
            buffer = self._buffers[key] = np.empty(shape, np.uint8)
        return buffer[:shape[0]]        # the last strip of an image is shorter


def _test(plane: np.ndarray, low: int, high: int, top: int, result: np.ndarray) -> None:
    """Write where a plane is from low to high, both included, or not between them if low > high.

    top: no value of the plane is above.
    """
    if low > high:
        cv2.inRange(plane, high + 1, low - 1, dst=result)
        cv2.bitwise_not(result, dst=result)
    elif low <= 0:
        cv2.threshold(plane, high, 255, cv2.THRESH_BINARY_INV, dst=result)
    elif high >= top:
        cv2.threshold(plane, low - 1, 255, cv2.THRESH_BINARY, dst=result)
    else:
        cv2.inRange(plane, low, high, dst=result)


def _conjunction(tests: Sequence[np.ndarray], result: np.ndarray) -> None:
    if not tests:
        result[:] = 255
    elif len(tests) == 1:
        np.copyto(result, tests[0])
    else:
        cv2.bitwise_and(tests[0], tests[1], dst=result)
        for test in tests[2:]:
            cv2.bitwise_and(result, test, dst=result)
