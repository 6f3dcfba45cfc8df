"""The picture of fitted bounds: histograms of the pixels of each color, and of all others."""
from typing import List, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from img_recog.recognition.fitting.histograms import SHAPE, UNIT, Sampled
from img_recog.recognition.fitting.volume import Box, edges_of
from img_recog.recognition.range_axes import (GREY, SMALL, fill, hue_rgb, scale_counts, shade,
                                              typical_rgb)
from img_recog.recognition.settings import Color
from img_recog.recognition.tuning_statistics import Histogram, spans

_WIDTH_IN, _ROW_IN, _DPI = 12.0, 2.6, 100
_NAMES = 'hue', 'saturation', 'value'
_STRIP = -0.06      # share of the height, of the strip of hues below the axis


class Profile(NamedTuple):
    """Counts along hue, saturation and value, each of the pixels within the other two bounds.

    In each, passing_px are those of the color, all_px those that are not of it.
    """

    color: Color
    counts: List[Histogram]


def profile(color: Color, sampled: Sampled) -> Profile:
    """Return the counts of samples along the axes."""
    edges = edges_of(Box(color.hue, color.saturation, color.value), SHAPE[0])
    inside = [np.arange(low, end) % size for low, end, size in zip(edges[::2], edges[1::2], SHAPE)]
    counts = []
    for axis, size in enumerate(SHAPE):
        part = np.ix_(*(np.arange(size) if other == axis else values
                        for other, values in enumerate(inside)))
        others = tuple(other for other in range(3) if other != axis)
        counts.append(Histogram(*(pixels[part].sum(axis=others) / UNIT
                                  for pixels in (sampled.negative, sampled.positive))))
    return Profile(color, counts)


def draw(profiles: List[Profile]) -> Figure:
    """Return the picture: a row for each color, with hue, saturation and value."""
    figure = Figure(figsize=(_WIDTH_IN, _ROW_IN * len(profiles)), dpi=_DPI, facecolor='white')
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(len(profiles), 3, left=0.06, right=0.98, hspace=0.5, wspace=0.2,
                               top=1 - 0.35 / (_ROW_IN * len(profiles)),
                               bottom=0.5 / (_ROW_IN * len(profiles)))
    for row, (color, counts) in enumerate(profiles):
        for axis, (name, bounds) in enumerate(zip(_NAMES, (color.hue, color.saturation,
                                                           color.value))):
            axes = figure.add_subplot(grid[row, axis])
            axes.tick_params(labelsize=SMALL)
            for low, high in spans(bounds):
                shade(axes, low, high, color)
            fill(axes, counts[axis].all_px, GREY)
            fill(axes, counts[axis].passing_px, typical_rgb(color))
            both = counts[axis].all_px + counts[axis].passing_px
            scale_counts(axes, Histogram(both, counts[axis].passing_px), 1)
            axes.set_xlim(-2, SHAPE[axis] + 1)
            axes.set_title('{}: {} {}-{}'.format(color.name, name, *bounds), fontsize=SMALL + 1)
            if axis == 0:
                strip = axes.inset_axes((0, _STRIP, 1, -_STRIP), zorder=-1)
                strip.imshow(hue_rgb(np.arange(SHAPE[0]))[np.newaxis], aspect='auto')
                strip.set_axis_off()
    figure.text(0.06, 0.04 / (_ROW_IN * len(profiles)) * 2, 'Colored: pixels of the color within '
                'the other two bounds. Grey: pixels that are not of it, weighted. Shaded: within '
                'bounds.',
                fontsize=SMALL, color='0.35')
    return figure
