"""A synthetic scene: a hand shows a blue card and then a red one, in a plain room."""
from typing import Tuple

import cv2
import numpy as np

from img_recog.camera.source import FrameSource

# In frames; at 30 Hz: empty for 1 s, blue 2 s, empty 3 s, red 2 s, empty 2 s.
PERIOD_FRAMES = 300
BLUE_FRAMES = range(30, 90)
RED_FRAMES = range(180, 240)

# In RGB. OpenCV hue (0-180) of the cards: 113 and 174, within the article's blue and red.
BLUE = (25, 70, 215)
RED = (215, 25, 60)
_WALL, _FLOOR, _SKIRTING = (206, 200, 190), (150, 130, 112), (232, 228, 222)
_FRAME, _PICTURE, _HILL = (120, 98, 80), (226, 220, 205), (168, 160, 142)
_TABLE, _LEG, _SKIN, _SLEEVE = (176, 148, 118), (140, 114, 90), (222, 184, 160), (96, 96, 100)

_WIDTH, _HEIGHT = 640, 480                  # the grid of the scene, scaled to the image size
_CARD_WIDTH, _CARD_HEIGHT = 220, 260
_CARD_LEFT, _CARD_TOP = 210, 70
_ENTRY_OFFSETS = (300, 170, 80, 25)         # most of the card is visible from its first frame on


def draw_frame(number: int, width: int = _WIDTH, height: int = _HEIGHT) -> np.ndarray:
    """Return frame `number` of the scene, which depends on the arguments only.

    The image is uint8 of shape (height, width, 3), rgb8. At 640x480 a visible card has at least
    20,000 px of its color; a frame without a card has none.
    """
    return _draw_card(_draw_room(width, height), number)


class SyntheticSource(FrameSource):
    """The synthetic scene as an endless source; it begins when the blue card comes."""

    def __init__(self, width: int, height: int, rate_hz: float):
        self.name = 'synthetic'
        self.width, self.height = width, height
        self.rate_hz = self.expected_hz = rate_hz
        self.description = 'synthetic scene, {}x{}, {:g} Hz'.format(width, height, rate_hz)
        self._room = _draw_room(width, height)
        self._frame_number = BLUE_FRAMES.start

    def read(self) -> np.ndarray:
        frame = _draw_card(self._room.copy(), self._frame_number)
        self._frame_number += 1
        return frame


class _Pen:
    """Draws on an image in the grid of the scene."""

    def __init__(self, image: np.ndarray):
        self._image = image
        self._scale = np.array([image.shape[1] / _WIDTH, image.shape[0] / _HEIGHT])

    def _pixel(self, x: float, y: float) -> Tuple[int, int]:
        column, row = np.array([x, y]) * self._scale
        return int(round(column)), int(round(row))

    def box(self, left, top, right, bottom, color):
        first, last = self._pixel(left, top), self._pixel(right, bottom)
        cv2.rectangle(self._image, first, (last[0] - 1, last[1] - 1), color, cv2.FILLED)

    def disc(self, x, y, radius, color):
        axes = tuple(max(1, int(round(v))) for v in radius * self._scale)
        cv2.ellipse(self._image, self._pixel(x, y), axes, 0, 0, 360, color, cv2.FILLED)

    def polygon(self, points, color):
        cv2.fillPoly(self._image, [np.array([self._pixel(x, y) for x, y in points])], color)


def _draw_room(width: int, height: int) -> np.ndarray:
    image = np.empty((height, width, 3), np.uint8)
    image[:] = _WALL
    pen = _Pen(image)
    pen.box(0, 370, _WIDTH, _HEIGHT, _FLOOR)
    pen.box(0, 358, _WIDTH, 370, _SKIRTING)
    pen.box(470, 60, 600, 160, _FRAME)
    pen.box(478, 68, 592, 152, _PICTURE)
    pen.polygon([(478, 152), (515, 100), (545, 130), (565, 112), (592, 152)], _HILL)
    pen.box(45, 300, 60, 430, _LEG)
    pen.box(160, 300, 175, 430, _LEG)
    pen.box(30, 285, 190, 302, _TABLE)
    return image


def _draw_card(image: np.ndarray, number: int) -> np.ndarray:
    step = number % PERIOD_FRAMES
    for frames, color in ((BLUE_FRAMES, BLUE), (RED_FRAMES, RED)):
        if step in frames:
            from_edge = min(step - frames.start, frames.stop - 1 - step)
            offset = _ENTRY_OFFSETS[from_edge] if from_edge < len(_ENTRY_OFFSETS) else 0
            _draw_hand_with_card(_Pen(image), offset, color)
    return image


def _draw_hand_with_card(pen: _Pen, offset: float, color) -> None:
    left, top = _CARD_LEFT + offset, _CARD_TOP
    right, bottom = left + _CARD_WIDTH, top + _CARD_HEIGHT
    pen.polygon([(right - 90, bottom + 20), (right - 30, bottom + 10),
                 (right + 70, _HEIGHT), (right - 30, _HEIGHT)], _SLEEVE)
    pen.disc(right - 60, bottom + 15, 44, _SKIN)
    pen.box(left, top, right, bottom, color)
    pen.disc(right - 70, bottom - 8, 17, _SKIN)
