"""What a picture of a film consists of: cards with a title, text, images, and charts."""
import math
from typing import Sequence, Tuple

import cv2
import numpy as np

HISTORY_S = 10.0        # shown by a chart
TITLE_PX = 24           # height of the title of a card
SMALL, NORMAL = 0.45, 0.55              # scales of text
CARD = 255              # white; to fill with one number is a hundred times faster
INK, SOFT = (39, 24, 17), (219, 213, 209)        # BGR
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


def put_chart(picture: np.ndarray, box: Box, title: str, lines: Sequence[tuple], now_s: float,
              limits: Sequence[tuple]) -> None:
    """Draw lines of (name, color, [(time, value), ...]) over the last seconds.

    limits: (value, color) of dashed lines.
    """
    left, top, width, height = box
    put_card(picture, box, title)
    x0, x1, y0 = left + 60, left + width - 12, top + height - 24
    y1 = _legend(picture, [line[:2] for line in lines], (x0, x1), top + 32) + 14
    values = [value for _, _, points in lines for _, value in points]
    values += [limit for limit, _ in limits]
    low, high = value_range(values)
    step = tick_step(high - low)

    def at(time_s: float, value: float) -> Tuple[int, int]:
        return (int(x1 + (time_s - now_s) / HISTORY_S * (x1 - x0)),
                int(y0 - (value - low) / (high - low) * (y0 - y1)))
    tick = math.ceil(low / step) * step
    while tick <= high:
        y = at(now_s, tick)[1]
        cv2.line(picture, (x0, y), (x1, y), SOFT, 1)
        put_text(picture, '{:g}'.format(round(tick, 9)), (left + 6, y + 4), SMALL)
        tick += step
    for seconds in range(0, int(HISTORY_S) + 1, 5):
        x = at(now_s - seconds, low)[0]
        cv2.line(picture, (x, y0), (x, y1), SOFT, 1)
        put_text(picture, '{} s'.format(-seconds), (x - 28, y0 + 16), SMALL)
    for limit, color in limits:
        y = at(now_s, limit)[1]
        for x in range(x0, x1, 12):
            cv2.line(picture, (x, y), (x + 5, y), color, 1)
    for _, color, points in lines:
        if points:
            cv2.polylines(picture, [np.array([at(*point) for point in points], np.int32)], False,
                          color, 2, cv2.LINE_AA)


def _legend(picture: np.ndarray, entries: Sequence[tuple], columns: Tuple[int, int], y: int
            ) -> int:
    """Draw names and colors between two columns, in rows from y on; return y of the last row."""
    x = columns[0]
    for name, color in entries:
        end = x + 24 + text_width(name, SMALL)
        if end > columns[1] and x > columns[0]:
            x, y, end = columns[0], y + 16, end - x + columns[0]
        cv2.line(picture, (x, y), (x + 18, y), color, 3)
        put_text(picture, name, (x + 24, y + 4), SMALL)
        x = max(end + 20, x + 110)
    return y


def value_range(values: Sequence[float]) -> Tuple[float, float]:
    """Return a range that contains the values and 0, and is not empty.

    >>> value_range([2.0, 5.0]), value_range([-1.0]), value_range([])
    ((0.0, 5.0), (-1.0, 0.0), (0.0, 1.0))
    """
    low, high = min([0.0, *values]), max([0.0, *values])
    return (low, high) if high - low > 1e-6 else (low, low + 1.0)


def tick_step(span: float) -> float:
    """Return 1, 2 or 5 times a power of ten, so that there are at most five steps in a span.

    >>> [tick_step(span) for span in (1.0, 4.0, 6.0, 1100.0)]
    [0.2, 1.0, 2.0, 500.0]
    """
    power = 10.0 ** math.floor(math.log10(span / 5))
    return next(power * factor for factor in (1, 2, 5, 10) if span <= 5 * power * factor * 1.001)
