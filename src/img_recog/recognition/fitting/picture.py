"""The picture of fitted bounds: histograms of the pixels of each color, and of all others."""
from typing import List, NamedTuple, Tuple

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from img_recog.recognition.fitting.histograms import CHANNELS, HUES, SHAPE, UNIT, Sampled
from img_recog.recognition.fitting.volume import Box, edges_of
from img_recog.recognition.recognition_settings import Color

_WIDTH_IN, _ROW_IN = 12.0, 2.6
_STRIP = -0.06      # share of the height, of the strip of hues below the axis
_GREY, _SMALL = '0.78', 8       # the latter in points, of text
# the scale of the counts ends at 25 times the highest colored bar, so that it stays visible
_MAX_GREY_RATIO = 25


class Histogram(NamedTuple):
    """Pixels at each value of hue, saturation or value, within the bounds of the other two.

    of_color: of the color; others: not of it.
    """

    of_color: np.ndarray
    others: np.ndarray


class Profile(NamedTuple):
    """The histograms of a color along hue, saturation and value."""

    color: Color
    counts: List[Histogram]


def profile(color: Color, sampled: Sampled) -> Profile:
    """Return the counts of samples along the axes."""
    edges = edges_of(Box(color.hue, color.saturation, color.value), SHAPE[0])
    counts = []
    for pixels in sampled:
        levels = np.unravel_index(pixels.indices, SHAPE)
        inside = [(each - low) % size < end - low for each, low, end, size in zip(
            levels, edges[::2], edges[1::2], SHAPE)]
        counts.append([np.bincount(
            levels[axis], pixels.counts * inside[axis - 1] * inside[axis - 2], size) / UNIT
            for axis, size in enumerate(SHAPE)])
    return Profile(color, [Histogram(*each) for each in zip(*counts)])


def size_in(profiles: List[Profile]) -> Tuple[float, float]:
    """Return width and height of the picture in inches."""
    return _WIDTH_IN, _ROW_IN * len(profiles)


def draw(figure: Figure, profiles: List[Profile]) -> None:
    """Draw a row for each color, with hue, saturation and value."""
    grid = figure.add_gridspec(len(profiles), 3, left=0.06, right=0.98, hspace=0.5, wspace=0.2,
                               top=1 - 0.35 / (_ROW_IN * len(profiles)),
                               bottom=0.5 / (_ROW_IN * len(profiles)))
    for row, (color, counts) in enumerate(profiles):
        for axis, (name, bounds) in enumerate(zip(CHANNELS, (color.hue, color.saturation,
                                                             color.value))):
            axes = figure.add_subplot(grid[row, axis])
            axes.tick_params(labelsize=_SMALL)
            color_rgb = _hue_rgb(np.array([color.middle_hue]))[0]
            for low, high in _spans(bounds):
                axes.axvspan(low - 0.5, high + 0.5, color=color_rgb, alpha=0.18, linewidth=0)
                for edge in (low - 0.5, high + 0.5):
                    axes.axvline(edge, color='0.25', linewidth=0.9, linestyle='--', zorder=1.5)
            _fill(axes, counts[axis].others, _GREY)
            _fill(axes, counts[axis].of_color, color_rgb)
            _scale(axes, counts[axis])
            axes.set_xlim(-2, SHAPE[axis] + 1)
            axes.set_title('{}: {} {}-{}'.format(color.name, name, *bounds), fontsize=_SMALL + 1)
            if axis == 0:
                strip = axes.inset_axes((0, _STRIP, 1, -_STRIP), zorder=-1)
                strip.imshow(_hue_rgb(np.arange(SHAPE[0]))[np.newaxis], aspect='auto')
                strip.set_axis_off()
    figure.text(0.06, 0.04 / (_ROW_IN * len(profiles)) * 2, 'Colored: pixels of the color within '
                'the other two bounds. Grey: pixels that are not of it, weighted. Shaded: within '
                'bounds.',
                fontsize=_SMALL, color='0.35')


def _fill(axes: Axes, counts: np.ndarray, color) -> None:
    """Draw counts of the values from 0 on as bars without gaps."""
    # with a zero at both ends; without it, the first and the last bar have half the width
    axes.fill_between(range(-1, len(counts) + 1), np.pad(counts, 1), step='mid', color=color,
                      linewidth=0, zorder=2)


def _scale(axes: Axes, counts: Histogram) -> None:
    """Set a square root scale, so that small counts are visible beside large ones.

    The grey bars may be cut off.
    """
    top = max(1, min((counts.others + counts.of_color).max(),
                     _MAX_GREY_RATIO * counts.of_color.max()))
    axes.set_yscale('function', functions=(lambda y: np.sqrt(np.maximum(y, 0)), np.square))
    axes.set_ylim(0, 1.1 * top)
    power = 10 ** int(np.log10(top))
    round_top = max(step * power for step in (1, 2, 5) if step * power <= top)
    axes.set_yticks(sorted({0, round_top // 10, 4 * round_top // 10, round_top}))
    axes.set_ylabel('pixels', fontsize=_SMALL)


def _hue_rgb(hues: np.ndarray) -> np.ndarray:
    """Return the saturated RGB colors of hues (0-180), float of shape (hues, 3), 0 to 1."""
    hsv = np.full((1, len(hues), 3), 225, np.uint8)
    hsv[0, :, 0], hsv[0, :, 1] = hues % HUES, 255
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0] / 255


def _spans(bounds: Tuple[int, int]) -> List[Tuple[int, int]]:
    """Return a range of hues as one span, or as two if it wraps through 0; all ends included."""
    low, high = bounds
    return [(low, high)] if low <= high else [(low, HUES), (0, high)]
