"""Draws one picture of a film: camera, masked images, map and charts side by side."""
import math
from collections import deque
from typing import Deque, List, Optional, Sequence, Tuple

import cv2
import numpy as np

from img_recog.recognition.recognition_settings import Color
from img_recog.replay.plot_data import Rows

HISTORY_S = 10.0        # shown by a chart
TITLE_PX = 24           # height of the title of a card
SMALL, NORMAL = 0.45, 0.55              # scales of text
CARD = 255              # white; to fill with one number is a hundred times faster
INK, SOFT = (39, 24, 17), (219, 213, 209)        # BGR
_FONT = cv2.FONT_HERSHEY_SIMPLEX

Box = Tuple[int, int, int, int]         # left, top, width, height in pixels
Points = List[Tuple[float, float]]      # of a line: time in s, value

WIDTH, HEIGHT = 1280, 720
_MARGIN = 10
# BGR
_PAGE = (246, 244, 243)
_PATH, _SCAN, _ROBOT, _ASKED, _DRIVEN = ((235, 99, 37), (38, 38, 220), (74, 163, 22),
                                         (215, 121, 78), (43, 142, 242))
_LEFT = 480             # width of the camera image
_MASKS = 230            # width of the column with the masked images
_ROW = 360              # height of the upper row
_MAP_MARGIN_M, _MIN_MAP_M = 0.3, 2.0
_ROBOT_M = 0.15
_JUMP_M = 0.5           # between two positions that follow one another: the robot was moved
_MIN_SPEED = 0.2        # m/s; the chart shows at least those up to one and a half times this one
_HUE_STEP = 15          # between the colors of two lines, of 180


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


class FilmPicture:
    """Draws pictures of one film, in the order of time.

    What is known beside the images may be set at any time. pose: x and y in m, yaw in rad; None if
    not known. scan: points (n, 2) in m in the frame of the map. asked, driven: speed in m/s.
    """

    def __init__(self, colors: Sequence[Color], outlines: Sequence[np.ndarray]):
        """colors: that are recognized; may be empty.

        outlines: (corners, 2) in m of what stands in the world.
        """
        self._colors, self._outlines = colors, list(outlines)
        self.asked = self.driven = 0.0
        self.pose: Optional[Tuple[float, float, float]] = None
        self._position = 0.0, 0.0       # the last one
        self.scan = np.empty((0, 2))
        self._shown = line_colors(colors)
        self._areas: Deque[tuple] = deque()
        self._speeds: Deque[tuple] = deque()
        self._paths: List[Rows] = []     # a new one where it was moved
        corners = np.concatenate(self._outlines) if self._outlines else np.zeros((1, 2))
        self._low, self._high = corners.min(axis=0), corners.max(axis=0)
        # numpy takes thirty times longer to fill an array with a color than to copy it
        self._page = np.full((HEIGHT, WIDTH, 3), _PAGE, np.uint8)

    def draw(self, time_s: float, image: np.ndarray, masked: Sequence[np.ndarray],
             areas_px: Sequence[int]) -> np.ndarray:
        """Return the picture (720, 1280, 3) of a time, bgr8.

        image: bgr8 of shape (height, width, 3); masked: one such image for each color.
        areas_px: of each color.
        """
        self._remember(time_s, areas_px)
        picture = self._page.copy()
        top = _MARGIN
        left = 3 * _MARGIN + _LEFT + _MASKS
        width = left - 2 * _MARGIN      # of what is left of the map
        put_image(picture, (_MARGIN, top, _LEFT if self._colors else width, _ROW),
                  'camera, {:.2f} s'.format(time_s), image)
        self._draw_masked(picture, masked, areas_px, image.shape[:2], 2 * _MARGIN + _LEFT, top)
        self._draw_map(picture, (left, top, WIDTH - left - _MARGIN, _ROW + TITLE_PX))
        lower = top + _ROW + TITLE_PX + _MARGIN
        height = HEIGHT - lower - _MARGIN
        if self._colors:
            put_chart(picture, (_MARGIN, lower, width, height),
                      'areas of the colors (pixels; dashed: limit)',
                      [(color.name, shown, [(row[0], row[1 + number]) for row in self._areas])
                       for number, (color, shown) in enumerate(zip(self._colors, self._shown))],
                      time_s, [(float(color.area_limit_px), shown)
                               for color, shown in zip(self._colors, self._shown)])
        else:
            left = _MARGIN
        asked, driven = ([(row[0], row[column]) for row in self._speeds] for column in (1, 2))
        name, asked = cut_off('asked', asked, driven)
        put_chart(picture, (left, lower, WIDTH - left - _MARGIN, height), 'speed (m/s)',
                  [(name, _ASKED, asked), ('driven', _DRIVEN, driven)], time_s, [])
        return picture

    def _remember(self, time_s: float, areas_px: Sequence[int]) -> None:
        self._areas.append((time_s, *areas_px))
        self._speeds.append((time_s, self.asked, self.driven))
        for history in (self._areas, self._speeds):
            while history[0][0] < time_s - HISTORY_S:
                history.popleft()
        if self.pose is not None:
            position = self.pose[:2]
            if not self._paths or math.dist(self._position, position) > _JUMP_M:
                self._paths.append(Rows(2, 2))
            self._paths[-1].add(position)
            self._position = position
            self._low = np.minimum(self._low, position)
            self._high = np.maximum(self._high, position)

    def _draw_masked(self, picture: np.ndarray, masked: Sequence[np.ndarray],
                     areas_px: Sequence[int], size: Tuple[int, ...], left: int, top: int) -> None:
        """Draw the masked images in as many columns as make them largest."""
        rows_px, columns_px = size
        columns, (width, height) = masks_grid(len(self._colors), columns_px / rows_px)
        titles = ['{}: {} px'.format(color.name, area_px) for color, area_px in zip(
            self._colors, areas_px)]
        # of the longest title that there can be: it does not change from picture to picture
        scale = min((fitting_scale('{}: {} px'.format(color.name, rows_px * columns_px), width)
                     for color in self._colors), default=NORMAL)
        for number, image in enumerate(masked[:len(titles)]):
            row, column = divmod(number, columns)
            place = left + column * (width + _MARGIN), top + row * (height + TITLE_PX + _MARGIN)
            put_image(picture, (*place, width, height), titles[number], image, scale)

    def _draw_map(self, picture: np.ndarray, box: Box) -> None:
        left, top, width, height = box
        put_card(picture, box, 'map' if self.pose is None else
                 'map: x {:.2f} m, y {:.2f} m, {:.0f} deg'.format(
                     *self.pose[:2], math.degrees(self.pose[2])))
        area = picture[top + TITLE_PX:top + height, left:left + width]
        center = (self._low + self._high) / 2
        size_m = max(_MIN_MAP_M, *(self._high - self._low + 2 * _MAP_MARGIN_M))
        scale = min(area.shape[0], area.shape[1]) / size_m
        middle = np.array([area.shape[1], area.shape[0]]) / 2

        def at(points: np.ndarray) -> np.ndarray:
            # x is up and y is left, as in the picture of the simulation from above
            shift = (np.asarray(points, float).reshape(-1, 2) - center)[:, ::-1] * -scale
            return np.round(middle + shift).astype(np.int32)
        for outline in self._outlines:
            cv2.fillPoly(area, [at(outline)], SOFT, cv2.LINE_AA)
            cv2.polylines(area, [at(outline)], True, INK, 1, cv2.LINE_AA)
        for point in at(self.scan):
            cv2.circle(area, tuple(int(each) for each in point), 1, _SCAN, -1)
        for path in self._paths:
            cv2.polylines(area, [at(path.array())], False, _PATH, 2, cv2.LINE_AA)
        if self.pose is not None:
            x, y, yaw = self.pose
            turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
            arrow = np.array([(1.0, 0.0), (-0.7, 0.7), (-0.35, 0.0), (-0.7, -0.7)])
            cv2.fillPoly(area, [at(arrow * _ROBOT_M @ turn.T + (x, y))], _ROBOT, cv2.LINE_AA)
        corner = area.shape[1] - 30, area.shape[0] - 18
        for name, (x, y), place in (('x', (1, 0), (-4, -6)), ('y', (0, 1), (-12, 4))):
            end = corner[0] - round(y * scale), corner[1] - round(x * scale)
            cv2.line(area, corner, end, INK, 2)
            put_text(area, name, (end[0] + place[0], end[1] + place[1]), SMALL)
        put_text(area, '1 m', (corner[0] - round(scale / 2) - 12, corner[1] + 14), SMALL)


def cut_off(name: str, asked: Points, driven: Points) -> Tuple[str, Points]:
    """Return the name and the points of commands, none far above what is driven.

    They would make its line flat; they end at the edge of the chart.

    >>> cut_off('asked', [(0.0, 10.0), (0.1, -10.0)], [(0.0, 0.2), (0.1, 0.1)])
    ('asked: -10 to 10, cut off', [(0.0, 0.3), (0.1, -0.3)])
    """
    edge = round(1.5 * max(_MIN_SPEED, *(abs(value) for _, value in driven)), 2)
    values = [value for _, value in asked]
    if all(abs(value) <= edge for value in values):
        return name, asked
    return ('{}: {:.3g} to {:.3g}, cut off'.format(name, min(0.0, *values), max(0.0, *values)),
            [(time_s, max(-edge, min(edge, value))) for time_s, value in asked])


def line_colors(colors: Sequence[Color]) -> List[Tuple[int, int, int]]:
    """Return the color of each line, in BGR, dark enough for a white page.

    It has the middle hue of the color, or the nearest one that no other line has.
    """
    hues: List[int] = []
    for color in colors:
        free = [hue for hue in range(180)[::_HUE_STEP] if all(
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


def masks_grid(count: int, ratio: float) -> Tuple[int, Tuple[int, int]]:
    """Return the number of columns for masked images, and width and height of each in pixels.

    count: of the images; ratio: of their width to their height.

    >>> masks_grid(2, 4 / 3), masks_grid(12, 4 / 3)
    ((1, (230, 163)), (3, (70, 64)))
    """
    found = []
    for columns in range(1, max(1, count) + 1):
        rows = -(-max(1, count) // columns)
        width = (_MASKS - _MARGIN * (columns - 1)) // columns
        height = (_ROW + TITLE_PX - _MARGIN * (rows - 1)) // rows - TITLE_PX
        if min(width, height) > 0:
            found.append((min(width, height * ratio), -columns, (width, height)))
    _, columns, size = max(found, default=(0.0, -1, (_MASKS, 1)))
    return -columns, size
