"""Draws one picture of a film: camera, masked images, map and charts side by side."""
import math
from collections import deque
from typing import Deque, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.settings import Color

WIDTH, HEIGHT = 1280, 720
_HISTORY_S = 10.0
_MARGIN, _TITLE = 10, 24
_FONT, _SMALL, _NORMAL = cv2.FONT_HERSHEY_SIMPLEX, 0.45, 0.55
# BGR
_PAGE, _CARD, _INK, _SOFT = (246, 244, 243), (255, 255, 255), (39, 24, 17), (219, 213, 209)
_PATH, _SCAN, _ROBOT, _ASKED, _DRIVEN = ((235, 99, 37), (38, 38, 220), (74, 163, 22),
                                         (235, 99, 37), (74, 163, 22))
_LEFT = 480             # width of the camera image
_MASKS = 230            # width of the column with the masked images
_ROW = 360              # height of the upper row
_MAP_MARGIN_M, _MIN_MAP_M = 0.3, 2.0
_ROBOT_M = 0.15
_HUE_STEP = 15          # between the colors of two lines, of 180

Box = Tuple[int, int, int, int]         # left, top, width, height in pixels


class FilmState(NamedTuple):
    """What is known at a time.

    image: bgr8 of shape (height, width, 3); masked: one such image for each color.
    areas_px: of each color. pose: x and y in m, yaw in rad; None if not known.
    scan: points (n, 2) in m in the frame of the map.
    asked, driven: speed in m/s.
    """

    time_s: float
    image: np.ndarray
    masked: Sequence[np.ndarray]
    areas_px: Sequence[int]
    pose: Optional[Tuple[float, float, float]]
    scan: np.ndarray
    asked: float
    driven: float


class FilmPicture:
    """Draws pictures of one film, in the order of time."""

    def __init__(self, colors: Sequence[Color], outlines: Sequence[np.ndarray]):
        """colors: that are recognized. outlines: (corners, 2) in m of what stands in the world."""
        self._colors, self._outlines = colors, list(outlines)
        self._shown = _shown(colors)
        self._areas: Deque[tuple] = deque()
        self._speeds: Deque[tuple] = deque()
        self._path: List[Tuple[float, float]] = []
        corners = np.concatenate(self._outlines) if self._outlines else np.zeros((1, 2))
        self._low, self._high = corners.min(axis=0), corners.max(axis=0)

    def draw(self, state: FilmState) -> np.ndarray:
        """Return the picture (720, 1280, 3) of a state, bgr8."""
        self._remember(state)
        picture = np.full((HEIGHT, WIDTH, 3), _PAGE, np.uint8)
        top = _MARGIN
        _image(picture, (_MARGIN, top, _LEFT, _ROW), 'camera, {:.2f} s'.format(state.time_s),
               state.image)
        self._draw_masked(picture, state, 2 * _MARGIN + _LEFT, top)
        left = 3 * _MARGIN + _LEFT + _MASKS
        self._draw_map(picture, (left, top, WIDTH - left - _MARGIN, _ROW + _TITLE), state)
        lower = top + _ROW + _TITLE + _MARGIN
        height = HEIGHT - lower - _MARGIN
        width = left - 2 * _MARGIN
        _chart(picture, (_MARGIN, lower, width, height), 'areas of the colors (pixels)',
               [(color.name, shown, [(row[0], row[1 + number]) for row in self._areas])
                for number, (color, shown) in enumerate(zip(self._colors, self._shown))],
               state.time_s, [(float(color.area_limit_px), shown)
                              for color, shown in zip(self._colors, self._shown)])
        _chart(picture, (left, lower, WIDTH - left - _MARGIN, height), 'speed (m/s)',
               [('asked', _ASKED, [(row[0], row[1]) for row in self._speeds]),
                ('driven', _DRIVEN, [(row[0], row[2]) for row in self._speeds])],
               state.time_s, [])
        return picture

    def _remember(self, state: FilmState) -> None:
        self._areas.append((state.time_s, *state.areas_px))
        self._speeds.append((state.time_s, state.asked, state.driven))
        for history in (self._areas, self._speeds):
            while history[0][0] < state.time_s - _HISTORY_S:
                history.popleft()
        if state.pose is not None:
            self._path.append(state.pose[:2])
            self._low = np.minimum(self._low, state.pose[:2])
            self._high = np.maximum(self._high, state.pose[:2])

    def _draw_masked(self, picture: np.ndarray, state: FilmState, left: int, top: int) -> None:
        """Draw the masked images in as many columns as make them largest."""
        rows_px, columns_px = state.image.shape[:2]
        columns, (width, height) = _grid(len(self._colors), columns_px / rows_px)
        titles = ['{}: {} px'.format(color.name, area_px) for color, area_px in zip(
            self._colors, state.areas_px)]
        # of the longest title that there can be: it does not change from picture to picture
        scale = min((_fit('{}: {} px'.format(color.name, rows_px * columns_px), width)
                     for color in self._colors), default=_NORMAL)
        for number, image in enumerate(state.masked[:len(titles)]):
            row, column = divmod(number, columns)
            place = left + column * (width + _MARGIN), top + row * (height + _TITLE + _MARGIN)
            _image(picture, (*place, width, height), titles[number], image, scale)

    def _draw_map(self, picture: np.ndarray, box: Box, state: FilmState) -> None:
        left, top, width, height = box
        _card(picture, box, 'map' if state.pose is None else
              'map: x {:.2f} m, y {:.2f} m, {:.0f} deg'.format(
                  state.pose[0], state.pose[1], math.degrees(state.pose[2])))
        area = picture[top + _TITLE:top + height, left:left + width]
        center = (self._low + self._high) / 2
        size_m = max(_MIN_MAP_M, *(self._high - self._low + 2 * _MAP_MARGIN_M))
        scale = min(area.shape[0], area.shape[1]) / size_m
        middle = np.array([area.shape[1], area.shape[0]]) / 2

        def at(points: np.ndarray) -> np.ndarray:
            shift = (np.asarray(points, float).reshape(-1, 2) - center) * (scale, -scale)
            return np.round(middle + shift).astype(np.int32)
        for outline in self._outlines:
            cv2.fillPoly(area, [at(outline)], _SOFT, cv2.LINE_AA)
            cv2.polylines(area, [at(outline)], True, _INK, 1, cv2.LINE_AA)
        for point in at(state.scan):
            cv2.circle(area, tuple(int(each) for each in point), 1, _SCAN, -1)
        if self._path:
            cv2.polylines(area, [at(np.array(self._path))], False, _PATH, 2, cv2.LINE_AA)
        if state.pose is not None:
            x, y, yaw = state.pose
            turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
            arrow = np.array([(1.0, 0.0), (-0.7, 0.7), (-0.35, 0.0), (-0.7, -0.7)])
            cv2.fillPoly(area, [at(arrow * _ROBOT_M @ turn.T + (x, y))], _ROBOT, cv2.LINE_AA)
        meter = int(round(scale))
        foot = area.shape[0] - 8
        cv2.line(area, (8, foot), (8 + meter, foot), _INK, 2)
        _text(area, '1 m', (12 + meter, foot + 4), _SMALL)


def _shown(colors: Sequence[Color]) -> List[Tuple[int, int, int]]:
    """Return the color of each line, in BGR, dark enough for a white page.

    It has the middle hue of the color, or the nearest one that no other line has.
    """
    hues: List[int] = []
    for color in colors:
        free = [hue for hue in range(0, 180, _HUE_STEP) if all(
            _hue_distance(hue, used) >= _HUE_STEP for used in hues)]
        wanted = color.middle_hue
        if any(_hue_distance(wanted, used) < _HUE_STEP for used in hues) and free:
            wanted = min(free, key=lambda hue: _hue_distance(hue, color.middle_hue))
        hues.append(wanted)
    if not hues:        # OpenCV rejects an image without pixels
        return []
    pixels = cv2.cvtColor(np.array([[(hue, 220, 200) for hue in hues]], np.uint8),
                          cv2.COLOR_HSV2BGR)
    return [(int(blue), int(green), int(red)) for blue, green, red in pixels[0]]


def _hue_distance(first: int, second: int) -> int:
    """Return the distance of two hues on the circle of 180."""
    return min((first - second) % 180, (second - first) % 180)


def _grid(count: int, ratio: float) -> Tuple[int, Tuple[int, int]]:
    """Return the number of columns for masked images, and width and height of each.

    count: of the images; ratio: of their width to their height.
    """
    found = []
    for columns in range(1, max(1, count) + 1):
        rows = -(-max(1, count) // columns)
        width = (_MASKS - _MARGIN * (columns - 1)) // columns
        height = (_ROW + _TITLE - _MARGIN * (rows - 1)) // rows - _TITLE
        if min(width, height) > 0:
            found.append((min(width, height * ratio), -columns, (width, height)))
    _, columns, size = max(found, default=(0.0, -1, (_MASKS, 1)))
    return -columns, size


def _card(picture: np.ndarray, box: Box, title: str, scale: float = _NORMAL) -> None:
    left, top, width, height = box
    picture[top:top + height, left:left + width] = _CARD
    _text(picture, title, (left + 6, top + 17), scale)


def _fit(title: str, width: int) -> float:
    """Return the scale of a title that a card of this width has room for."""
    return min(_NORMAL, _NORMAL * (width - 12) / max(1, _text_width(title, _NORMAL)))


def _text(picture: np.ndarray, text: str, place: Tuple[int, int], scale: float) -> None:
    cv2.putText(picture, text, place, _FONT, scale, _INK, 1, cv2.LINE_AA)


def _text_width(text: str, scale: float) -> int:
    return cv2.getTextSize(text, _FONT, scale, 1)[0][0]


def _image(picture: np.ndarray, box: Box, title: str, image: np.ndarray,
           scale_of_title: float = _NORMAL) -> None:
    """Draw an image as large as the box allows, below its title."""
    left, top, width, height = box
    _card(picture, (left, top, width, height + _TITLE), title, scale_of_title)
    scale = min(width / image.shape[1], height / image.shape[0])
    size = max(1, int(image.shape[1] * scale)), max(1, int(image.shape[0] * scale))
    x, y = left + (width - size[0]) // 2, top + _TITLE + (height - size[1]) // 2
    picture[y:y + size[1], x:x + size[0]] = cv2.resize(
        image, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST)


def _chart(picture: np.ndarray, box: Box, title: str, lines: Sequence[tuple], now_s: float,
           limits: Sequence[tuple]) -> None:
    """Draw lines of (name, color, [(time, value), ...]) over the last seconds."""
    left, top, width, height = box
    _card(picture, box, title)
    x0, x1, y0 = left + 60, left + width - 12, top + height - 24
    y1 = _legend(picture, [line[:2] for line in lines], (x0, x1), top + 32) + 14
    values = [value for _, _, points in lines for _, value in points]
    values += [limit for limit, _ in limits]
    low, high = _range(values)
    step = _step(high - low)

    def at(time_s: float, value: float) -> Tuple[int, int]:
        return (int(x1 + (time_s - now_s) / _HISTORY_S * (x1 - x0)),
                int(y0 - (value - low) / (high - low) * (y0 - y1)))
    tick = math.ceil(low / step) * step
    while tick <= high:
        y = at(now_s, tick)[1]
        cv2.line(picture, (x0, y), (x1, y), _SOFT, 1)
        _text(picture, '{:g}'.format(round(tick, 9)), (left + 6, y + 4), _SMALL)
        tick += step
    for seconds in range(0, int(_HISTORY_S) + 1, 5):
        x = at(now_s - seconds, low)[0]
        cv2.line(picture, (x, y0), (x, y1), _SOFT, 1)
        _text(picture, '{} s'.format(-seconds), (x - 28, y0 + 16), _SMALL)
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
        end = x + 24 + _text_width(name, _SMALL)
        if end > columns[1] and x > columns[0]:
            x, y, end = columns[0], y + 16, end - x + columns[0]
        cv2.line(picture, (x, y), (x + 18, y), color, 3)
        _text(picture, name, (x + 24, y + 4), _SMALL)
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
