"""Areas, masks, masked images and centroids of colors."""
from typing import Dict, List, Optional, Set, Tuple

import cv2
import numpy as np

from img_recog.recognition.candidates import CELL, GROUP_PX
from img_recog.recognition.masks import GroupsInside, Masks
from img_recog.recognition.recognition_settings import RecognitionSettings

_TO_HSV = {'bgr8': cv2.COLOR_BGR2HSV, 'bgra8': cv2.COLOR_BGR2HSV,
           'rgb8': cv2.COLOR_RGB2HSV, 'rgba8': cv2.COLOR_RGB2HSV}
_TO_BGR = {'bgra8': cv2.COLOR_BGRA2BGR, 'rgb8': cv2.COLOR_RGB2BGR, 'rgba8': cv2.COLOR_RGBA2BGR}
ENCODINGS = tuple(_TO_HSV)
_WHOLE = (0.0, 1.0)
_BLACK = np.zeros(1, CELL)


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
