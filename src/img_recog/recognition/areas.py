"""Color ranges to areas, masks and masked images."""
from typing import Dict, List, Optional, Tuple

import cv2
import numpy as np

from img_recog.recognition.masks import Masks
from img_recog.recognition.settings import RecognitionSettings

_TO_HSV = {'bgr8': cv2.COLOR_BGR2HSV, 'bgra8': cv2.COLOR_BGR2HSV,
           'rgb8': cv2.COLOR_RGB2HSV, 'rgba8': cv2.COLOR_RGB2HSV}
_TO_BGR = {'bgra8': cv2.COLOR_BGRA2BGR, 'rgb8': cv2.COLOR_RGB2BGR, 'rgba8': cv2.COLOR_RGBA2BGR}
ENCODINGS = tuple(_TO_HSV)


class ColorExtractor:
    """Measures colors in images, in memory that is kept from image to image.

    What it returns is of the image measured last, and is overwritten by the next; nothing of that
    image may change before. The ranges are independent: a pixel may belong to several.
    """

    def __init__(self, settings: RecognitionSettings):
        self._buffers: Dict[object, np.ndarray] = {}
        self._image: Optional[np.ndarray] = None
        self._encoding = 'bgr8'
        self._bgr: Optional[np.ndarray] = None
        self._region = (slice(0), slice(0))
        self._areas: List[int] = []
        self._masks: List[np.ndarray] = []
        self._made: Optional[Masks] = None
        self.configure(settings)

    def configure(self, settings: RecognitionSettings) -> None:
        """Measure by these settings from the next image on."""
        self._settings, self._made = settings, None

    def measure(self, image: np.ndarray, encoding: str = 'bgr8') -> List[int]:
        """Return the number of pixels of each color, in the order of the settings.

        image: uint8 of shape (height, width, 3 or 4), whose rows may be apart in memory.
        encoding: one of ENCODINGS, the order of its channels.
        """
        self._image, self._encoding, self._bgr = image, encoding, None
        self._region = self._settings.region(image.shape[:2])
        part = image[self._region]
        if self._made is None or self._made.shape != part.shape[:2]:
            self._made = Masks(part.shape[:2], self._settings.colors)
        self._made.make(part, _TO_HSV[encoding])
        self._masks, self._areas = self._made.masks, self._made.areas_px
        if self._settings.min_blob_size > 1 and part.size:
            self._drop_small_blobs()
            self._areas = [cv2.countNonZero(mask) for mask in self._masks]
        return list(self._areas)

    def mask(self, number: int) -> np.ndarray:
        """Return where color `number` is: uint8 of shape (height, width), 255 inside, else 0."""
        whole = self._buffer('whole mask', self._image.shape[:2])
        whole[:] = 0
        whole[self._region] = self._masks[number]
        return whole

    def masked(self, number: int, result: Optional[np.ndarray] = None) -> np.ndarray:
        """Return the image in bgr8, uint8 of shape (height, width, 3), black but for a color.

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
                if self._image.size:
                    cv2.cvtColor(self._image, conversion, dst=self._bgr)
        return self._bgr

    def centroid(self, number: int) -> Optional[Tuple[float, float]]:
        """Return the mean x and y of a color's pixels, None if there are none.

        In pixels of the whole image: 0, 0 is the center of the upper left one.
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
