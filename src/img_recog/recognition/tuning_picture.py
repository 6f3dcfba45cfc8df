"""A picture that shows why a color is recognized in an image, or why not."""
from typing import List, Tuple

import cv2
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.range_axes import (GREY, SMALL, fill, hue_rgb, scale_counts, shade,
                                              typical_rgb)
from img_recog.recognition.settings import Color, RecognitionSettings
from img_recog.recognition.tuning_statistics import (HUES, LEVELS, ColorStatistics, Histogram,
                                                     frame_statistics, spans)

DPI = 100
# inches
_WIDTH, _MARGIN, _RIGHT = 12.0, 0.3, 11.75
_FRAME_TOP, _FRAME_WIDTH, _FRAME_HEIGHT = 0.45, 4.4, 3.3
_HUE_LEFT, _HUE_HEIGHT, _STRIP_HEIGHT, _RANGE_HEIGHT = 6.0, 2.3, 0.14, 0.2
_ROW_HEIGHT, _ROW_TOP, _PLOT_HEIGHT = 2.85, 0.62, 1.65
_MASKED_WIDTH, _PLOT_LEFTS, _PLOT_WIDTH = 3.0, (4.1, 8.4), 3.35
_FOOT_HEIGHT = 0.35

_ABOVE, _BELOW = '#1a7f37', '#b42318'
_NORMAL, _LARGE = 9, 12     # points
_MAX_LENGTH = 12                        # characters of the names beside the hue ranges
_MAX_IMAGE_PX = 1000                    # larger images are scaled down before they are drawn
_FOOT = ('Grey: all pixels (top plot), pixels with a hue within bounds (other plots). Colored: '
         'those of them that are also within the other bounds. Shaded: within bounds.')


def draw(image: np.ndarray, settings: RecognitionSettings) -> Tuple[Figure, List[int]]:
    """Return the picture of an image and the area of each color in pixels.

    image: bgr8, uint8 of shape (height, width, 3).
    At the top: the frame with the region of interest, and the hues with the range of each color.
    Below, one row for each color: the masked image, as the node publishes it, the area and its
    limit, and the saturation and value of the pixels whose hue is within bounds.
    """
    extractor = ColorExtractor(settings)
    areas_px = extractor.measure(image)
    statistics = frame_statistics(extractor, areas_px, settings)
    ranges_height = _RANGE_HEIGHT * len(settings.colors)
    top_height = _FRAME_TOP + max(_FRAME_HEIGHT, ranges_height + _HUE_HEIGHT + 0.6) + 0.35
    sheet = _Sheet(top_height + _ROW_HEIGHT * len(settings.colors) + _FOOT_HEIGHT)
    _draw_frame(sheet, image, settings)
    _draw_hues(sheet, statistics.hue, settings)
    for number, color in enumerate(settings.colors):
        _draw_color(sheet, top_height + number * _ROW_HEIGHT, color, statistics.colors[number],
                    extractor.masked(number))
    sheet.text(_MARGIN, sheet.height - 0.12, _FOOT, SMALL, color='0.35')
    return sheet.figure, areas_px


def verdict(color: Color, area_px: int) -> str:
    """Return the area of a color and its limit: 'blue: 56463 px, above the limit of 1000 px'."""
    side = ('above' if area_px > color.area_limit_px else
            'below' if area_px < color.area_limit_px else 'not above')
    return '{}: {} px, {} the limit of {} px'.format(color.name, area_px, side,
                                                     color.area_limit_px)


def bounds(color: Color) -> str:
    """Return the bounds of a color: 'hue 50-150, saturation 100-255, value 100-255'."""
    return 'hue {}-{}, saturation {}-{}, value {}-{}'.format(
        *color.hue, *color.saturation, *color.value)


def reason(statistics: ColorStatistics) -> str:
    """Return, for each bound, how many pixels are not counted because of this bound alone."""
    hue_px, saturation_px, value_px = statistics.missed_px
    hint = '' if statistics.missed_hue is None else ' (most at {})'.format(statistics.missed_hue)
    dropped_px = statistics.in_bounds_px - statistics.area_px
    blobs = '; in too small blobs: {} px'.format(dropped_px) if dropped_px else ''
    return ('out of bounds only by hue: {} px{}, only by saturation: {} px, only by value: {} px'
            .format(hue_px, hint, saturation_px, value_px) + blobs)


class _Sheet:
    """A figure whose axes and texts are placed in inches from its upper left corner."""

    def __init__(self, height: float):
        self.height = height
        self.figure = Figure(figsize=(_WIDTH, height), dpi=DPI, facecolor='white')
        FigureCanvasAgg(self.figure)

    def axes(self, left: float, top: float, width: float, height: float):
        axes = self.figure.add_axes([left / _WIDTH, 1 - (top + height) / self.height,
                                     width / _WIDTH, height / self.height])
        axes.tick_params(labelsize=SMALL)
        return axes

    def text(self, left: float, baseline: float, text: str, size: float, **style) -> None:
        self.figure.text(left / _WIDTH, 1 - baseline / self.height, text, fontsize=size, **style)


def _draw_frame(sheet: _Sheet, image: np.ndarray, settings: RecognitionSettings) -> None:
    height, width = image.shape[:2]
    sheet.text(_MARGIN, _FRAME_TOP - 0.12, 'frame, {}x{} px'.format(width, height), _LARGE,
               fontweight='bold')
    axes = sheet.axes(_MARGIN, _FRAME_TOP, _FRAME_WIDTH, _FRAME_HEIGHT)
    _show(axes, image)
    rows, columns = settings.region((height, width))
    top, bottom, left, right = rows.start, rows.stop, columns.start, columns.stop
    if (top, bottom, left, right) != (0, height, 0, width):
        for style in ({'color': 'black', 'linewidth': 3}, {'color': 'white', 'linestyle': '--'}):
            axes.add_patch(Rectangle((left - 0.5, top - 0.5), max(0, right - left),
                                     max(0, bottom - top), fill=False, **style))
        axes.set_xlabel('only pixels inside the dashed lines are counted', fontsize=_NORMAL)


def _draw_hues(sheet: _Sheet, hue: Histogram, settings: RecognitionSettings) -> None:
    width, top = _RIGHT - _HUE_LEFT, _FRAME_TOP + _RANGE_HEIGHT * len(settings.colors)
    sheet.text(_HUE_LEFT, _FRAME_TOP - 0.12, 'hue', _LARGE, fontweight='bold')
    sheet.text(_HUE_LEFT + 0.5, _FRAME_TOP - 0.12, 'colored: saturation and value within the '
               'bounds of a color; grey: all', _NORMAL)
    ranges = sheet.axes(_HUE_LEFT, _FRAME_TOP, width, top - _FRAME_TOP - 0.05)
    plot = sheet.axes(_HUE_LEFT, top, width, _HUE_HEIGHT)
    strip = sheet.axes(_HUE_LEFT, top + _HUE_HEIGHT, width, _STRIP_HEIGHT)
    for number, color in enumerate(settings.colors):
        for low, high in spans(color.hue):
            ranges.barh(number, high - low + 1, 0.7, low - 0.5, color=typical_rgb(color))
            shade(plot, low, high, color)
    ranges.set_yticks(range(len(settings.colors)))
    ranges.set_yticklabels([_short(color.name) for color in settings.colors])
    ranges.set_ylim(len(settings.colors) - 0.5, -0.5)
    ranges.tick_params(length=0)
    ranges.set_frame_on(False)
    fill(plot, hue.all_px, GREY)
    _bars(plot, hue.passing_px)
    scale_counts(plot, hue, min(color.area_limit_px for color in settings.colors))
    strip.imshow(hue_rgb(np.arange(HUES))[np.newaxis], extent=(-0.5, HUES - 0.5, 0, 1),
                 aspect='auto')
    strip.set_yticks([])
    for axes in (ranges, plot, strip):
        axes.set_xlim(-1.5, HUES + 0.5)
        axes.set_xticks(range(0, HUES, 10) if axes is strip else [])


def _draw_color(sheet: _Sheet, top: float, color: Color, statistics: ColorStatistics,
                masked: np.ndarray) -> None:
    is_above = statistics.area_px > color.area_limit_px
    sheet.figure.add_artist(_line_across(sheet, top))
    sheet.text(_MARGIN, top + 0.27, verdict(color, statistics.area_px), _LARGE, fontweight='bold',
               color=_ABOVE if is_above else _BELOW)
    sheet.text(_MARGIN, top + 0.49, reason(statistics), _NORMAL)
    _show(sheet.axes(_MARGIN, top + _ROW_TOP, _MASKED_WIDTH, _PLOT_HEIGHT + 0.35), masked)
    planes = (('saturation', color.saturation, statistics.saturation),
              ('value', color.value, statistics.value))
    for left, (name, (low, high), counts) in zip(_PLOT_LEFTS, planes):
        axes = sheet.axes(left, top + _ROW_TOP, _PLOT_WIDTH, _PLOT_HEIGHT)
        shade(axes, low, high, color)
        fill(axes, counts.all_px, GREY)
        fill(axes, counts.passing_px, typical_rgb(color))
        scale_counts(axes, counts, color.area_limit_px)
        if not counts.all_px.any():
            axes.text(0.5, 0.5, 'no pixel has this hue', ha='center', fontsize=_NORMAL,
                      transform=axes.transAxes)
        axes.set_xlim(-3, LEVELS + 2)
        axes.set_xticks(range(0, LEVELS, 50))
        axes.set_xlabel('{} of pixels with hue {}-{}; bounds: {}-{}'.format(
            name, *color.hue, low, high), fontsize=SMALL)


def _line_across(sheet: _Sheet, top: float) -> Rectangle:
    return Rectangle((_MARGIN / _WIDTH, 1 - top / sheet.height),
                     (_RIGHT - _MARGIN) / _WIDTH, 0, transform=sheet.figure.transFigure,
                     edgecolor='0.7', linewidth=0.8)


def _show(axes, image: np.ndarray) -> None:
    """Show a bgr8 image at the upper left of the axes, in pixel coordinates, as large as fits."""
    height, width = image.shape[:2]
    scale = min(1.0, _MAX_IMAGE_PX / max(height, width))
    if scale < 1:
        image = cv2.resize(image, (max(1, round(width * scale)), max(1, round(height * scale))),
                           interpolation=cv2.INTER_AREA)
    axes.imshow(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), interpolation='nearest',
                extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    axes.set_anchor('NW')
    axes.set_xticks([])
    axes.set_yticks([])


def _bars(axes, counts: np.ndarray) -> None:
    """Draw a bar for each hue, in its color; one collection takes a tenth of the time of bar()."""
    hues = np.flatnonzero(counts)
    corners = [((hue - 0.5, 0), (hue - 0.5, counts[hue]), (hue + 0.5, counts[hue]),
                (hue + 0.5, 0)) for hue in hues]
    axes.add_collection(PolyCollection(corners, facecolors=hue_rgb(np.arange(HUES))[hues],
                                       linewidths=0, zorder=3), autolim=False)


def _short(name: str) -> str:
    return name if len(name) <= _MAX_LENGTH else name[:_MAX_LENGTH - 2] + '..'
