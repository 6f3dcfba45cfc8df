"""What the pictures of color ranges have in common: bars, ranges and scales of histograms."""
import cv2
import numpy as np

from img_recog.recognition.settings import Color
from img_recog.recognition.tuning_statistics import HUES, Histogram

GREY = '0.78'
SMALL = 8       # points, of text
# the scale of the counts ends at 25 times the highest colored bar, so that it stays visible
_MAX_GREY_RATIO = 25


def shade(axes, low: int, high: int, color: Color) -> None:
    """Shade a range, both ends included, in the color that it has."""
    axes.axvspan(low - 0.5, high + 0.5, color=typical_rgb(color), alpha=0.18, linewidth=0)
    for edge in (low - 0.5, high + 0.5):
        axes.axvline(edge, color='0.25', linewidth=0.9, linestyle='--', zorder=1.5)


def fill(axes, counts: np.ndarray, color) -> None:
    """Draw counts of the values from 0 on as bars without gaps."""
    # with a zero at both ends; without it, the first and the last bar have half the width
    axes.fill_between(range(-1, len(counts) + 1), np.pad(counts, 1), step='mid', color=color,
                      linewidth=0, zorder=2)


def scale_counts(axes, counts: Histogram, limit_px: int) -> None:
    """Set a square root scale, so that small counts are visible beside large ones.

    Its upper end is not below the area limit, so that a few pixels do not look like many. The
    grey bars may be cut off.
    """
    visible_px = max(_MAX_GREY_RATIO * counts.passing_px.max(), limit_px)
    top = max(1, min(counts.all_px.max(), visible_px))
    axes.set_yscale('function', functions=(lambda y: np.sqrt(np.maximum(y, 0)), np.square))
    axes.set_ylim(0, 1.1 * top)
    power = 10 ** int(np.log10(top))
    round_top = max(step * power for step in (1, 2, 5) if step * power <= top)
    axes.set_yticks(sorted({0, round_top // 10, 4 * round_top // 10, round_top}))
    axes.set_ylabel('pixels', fontsize=SMALL)


def typical_rgb(color: Color) -> np.ndarray:
    """Return the color in the middle of a range: red, green and blue from 0 to 1."""
    return hue_rgb(np.array([color.middle_hue]))[0]


def hue_rgb(hues: np.ndarray) -> np.ndarray:
    """Return the saturated RGB colors of hues (0-180), float of shape (hues, 3), 0 to 1."""
    hsv = np.full((1, len(hues), 3), 225, np.uint8)
    hsv[0, :, 0], hsv[0, :, 1] = hues % (HUES - 1), 255
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0] / 255
