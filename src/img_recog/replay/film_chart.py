"""Draws a chart of values over the last seconds of a film."""
import math
from typing import Sequence, Tuple

import cv2
import numpy as np

from img_recog.replay.film_drawing import SMALL, SOFT, Box, put_card, put_text, text_width

HISTORY_S = 10.0


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
    low, high = _range(values)
    step = _step(high - low)

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


def _range(values: Sequence[float]) -> Tuple[float, float]:
    """Return a range that contains the values and 0, and is not empty."""
    low, high = min([0.0, *values]), max([0.0, *values])
    return (low, high) if high - low > 1e-6 else (low, low + 1.0)


def _step(span: float) -> float:
    """Return 1, 2 or 5 times a power of ten, so that there are at most five steps in a span."""
    power = 10.0 ** math.floor(math.log10(span / 5))
    return next(power * factor for factor in (1, 2, 5, 10) if span <= 5 * power * factor * 1.001)
