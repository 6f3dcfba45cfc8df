"""A synthetic scene: a hand shows a blue card and then a red one, in a plain room."""
import functools
from typing import List, Optional, Tuple

import cv2
import numpy as np

from img_recog.camera.source import FrameSource

_Rgb = Tuple[int, int, int]
# In frames; at 30 Hz: empty for 1 s, blue 2 s, empty 3 s, red 2 s, empty 2 s.
PERIOD_FRAMES = 300
BLUE_FRAMES = range(30, 90)
RED_FRAMES = range(180, 240)

# In RGB. OpenCV hue (0-180) of the cards: 113 and 174, within the article's blue and red.
BLUE = (25, 70, 215)
RED = (215, 25, 60)
_WALL, _HILL, _SKIN, _SLEEVE = (206, 200, 190), (168, 160, 142), (222, 184, 160), (96, 96, 100)

_WIDTH, _HEIGHT = 640, 480                  # of the drawing, which is scaled to the image size
_ROOM = (                                   # left, top, right, bottom and color
    (0, 370, _WIDTH, _HEIGHT, (150, 130, 112)), (0, 358, _WIDTH, 370, (232, 228, 222)),
    (470, 60, 600, 160, (120, 98, 80)), (478, 68, 592, 152, (226, 220, 205)),
    (45, 300, 60, 430, (140, 114, 90)), (160, 300, 175, 430, (140, 114, 90)),
    (30, 285, 190, 302, (176, 148, 118)))   # floor, skirting, frame, picture, legs, table
_CARD_WIDTH, _CARD_HEIGHT = 220, 260
_CARD_LEFT, _CARD_TOP = 210, 70
_ENTRY_OFFSETS = (300, 170, 80, 25)         # most of the card is visible from its first frame on


def draw_frame(number: int, width: int = _WIDTH, height: int = _HEIGHT) -> np.ndarray:
    """Return frame `number` of the scene, which depends on the arguments only.

    The image is uint8 of shape (height, width, 3), rgb8, and read-only. At 640x480 a
    visible card has at least 20,000 px of its color; a frame without a card has none.
    """
    step = number % PERIOD_FRAMES
    for frames, color in ((BLUE_FRAMES, BLUE), (RED_FRAMES, RED)):
        if step in frames:
            from_edge = min(step - frames.start, frames.stop - 1 - step)
            offset = _ENTRY_OFFSETS[from_edge] if from_edge < len(_ENTRY_OFFSETS) else 0
            return _drawn(width, height, offset, color)
    return _drawn(width, height, 0, None)


class SyntheticSource(FrameSource):
    """The synthetic scene as an endless source; it begins when the blue card comes."""

    def __init__(self, width: int, height: int, rate_hz: float):
        self.name = 'synthetic'
        self.width, self.height = width, height
        self.rate_hz = self.expected_hz = rate_hz
        self.description = 'synthetic scene, {}x{}, {:g} Hz'.format(width, height, rate_hz)
        self._frame_number = BLUE_FRAMES.start

    def read(self) -> np.ndarray:
        frame = draw_frame(self._frame_number, self.width, self.height)
        self._frame_number += 1
        return frame


@functools.lru_cache(maxsize=1)     # most frames are equal to the one before
def _drawn(width: int, height: int, offset: int, color: Optional[_Rgb]) -> np.ndarray:
    """Return the room, with a card of this color that far from its place, unless it is None."""
    image = np.full((_HEIGHT, _WIDTH, 3), _WALL, np.uint8)
    for left, top, right, bottom, paint in _ROOM:
        image[top:bottom, left:right] = paint
    _polygon(image, [(478, 152), (515, 100), (545, 130), (565, 112), (592, 152)], _HILL)
    if color is not None:
        _draw_hand_with_card(image, offset, color)
    image = cv2.resize(image, (width, height), interpolation=cv2.INTER_NEAREST)
    image.setflags(write=False)
    return image


def _draw_hand_with_card(image: np.ndarray, offset: int, color: _Rgb) -> None:
    left, top = _CARD_LEFT + offset, _CARD_TOP
    right, bottom = left + _CARD_WIDTH, top + _CARD_HEIGHT
    _polygon(image, [(right - 90, bottom + 20), (right - 30, bottom + 10),
                     (right + 70, _HEIGHT), (right - 30, _HEIGHT)], _SLEEVE)
    _disc(image, right - 60, bottom + 15, 44, _SKIN)
    image[top:bottom, left:right] = color
    _disc(image, right - 70, bottom - 8, 17, _SKIN)


def _disc(image: np.ndarray, x: int, y: int, radius: int, color: _Rgb) -> None:
    cv2.ellipse(image, (x, y), (radius, radius), 0, 0, 360, color, cv2.FILLED)


def _polygon(image: np.ndarray, points: List[Tuple[int, int]], color: _Rgb) -> None:
    cv2.fillPoly(image, [np.array(points)], color)
