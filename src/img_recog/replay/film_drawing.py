"""What pictures of a film are drawn with: cards with a title, text, and images."""
from typing import Tuple

import cv2
import numpy as np

TITLE_PX = 24           # height of the title of a card
SMALL, NORMAL = 0.45, 0.55              # scales of text
CARD, INK, SOFT = (255, 255, 255), (39, 24, 17), (219, 213, 209)        # BGR
_FONT = cv2.FONT_HERSHEY_SIMPLEX

Box = Tuple[int, int, int, int]         # left, top, width, height in pixels


def put_card(picture: np.ndarray, box: Box, title: str, scale: float = NORMAL) -> None:
    """Draw an empty card with its title."""
    left, top, width, height = box
    picture[top:top + height, left:left + width] = CARD
    put_text(picture, title, (left + 6, top + 17), scale)


def fitting_scale(title: str, width: int) -> float:
    """Return the scale of a title that a card of this width has room for."""
    return min(NORMAL, NORMAL * (width - 12) / max(1, text_width(title, NORMAL)))


def put_text(picture: np.ndarray, text: str, place: Tuple[int, int], scale: float) -> None:
    """Draw a line of text; place: the left end (x, y) of its base line."""
    cv2.putText(picture, text, place, _FONT, scale, INK, 1, cv2.LINE_AA)


def text_width(text: str, scale: float) -> int:
    """Return the width of a line of text in pixels."""
    return cv2.getTextSize(text, _FONT, scale, 1)[0][0]


def put_image(picture: np.ndarray, box: Box, title: str, image: np.ndarray,
              scale_of_title: float = NORMAL) -> None:
    """Draw an image as large as the box allows, below its title."""
    left, top, width, height = box
    put_card(picture, (left, top, width, height + TITLE_PX), title, scale_of_title)
    scale = min(width / image.shape[1], height / image.shape[0])
    size = max(1, int(image.shape[1] * scale)), max(1, int(image.shape[0] * scale))
    x, y = left + (width - size[0]) // 2, top + TITLE_PX + (height - size[1]) // 2
    picture[y:y + size[1], x:x + size[0]] = cv2.resize(
        image, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST)
