"""The picture of a drive: areas, commands and velocity over time, and the path in the world."""
import colorsys
from typing import IO, Dict, List, Sequence, Tuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import FuncFormatter

from img_recog.command_line import results
from img_recog.replay.plot_data import SPEED, TIME, TURN, YAW, PlotData, X, Y

_SIZE_IN, _FONT_SIZE = (14.0, 9.0), 10.0
_DARK, _FAINT, _LINEAR, _ANGULAR = '#222222', '#999999', '#2ca02c', '#9467bd'
_START, _LAST, _WALL = '#2ca02c', '#d62728', '#d0d0d0'
_MIN_MARGIN_M = 0.02            # around the path in the close-up
_MAX_NAMES = 5                  # in an entry of a legend
_MAX_TICK_PX = 250_000          # longer numbers do not fit beside the axis
_LEGEND_COLUMNS = 4             # legends with more entries do not fit beside the title


def draw(file: IO[bytes], title: str, data: PlotData) -> None:
    """Draw the data and write the figure as PNG."""
    with results.picture(file, _SIZE_IN, _FONT_SIZE) as figure:
        draw_on(figure, title, data)


def draw_on(figure: Figure, title: str, data: PlotData) -> None:
    """Draw the charts; without colors, the others have the room of the areas."""
    figure.suptitle(title, x=0.06, y=0.98, ha='left')
    charts = [*([_draw_areas] if data.colors else []), _draw_commands, _draw_speed, _draw_position]
    # fixed positions: computing a layout takes as long as drawing
    grid = figure.add_gridspec(len(charts), 1, left=0.06, right=0.56, top=0.92, bottom=0.07,
                               hspace=0.32)
    for row, draw_chart in enumerate(charts):
        axes = figure.add_subplot(grid[row])
        draw_chart(axes, data)
        axes.set_xlim(0, max(data.end_s, 1e-3))
        axes.tick_params(labelbottom=draw_chart is charts[-1])
    axes.set_xlabel('time (s)')
    _draw_map(figure.add_axes((0.67, 0.43, 0.31, 0.49)), data)
    _draw_close_up(figure.add_axes((0.67, 0.07, 0.31, 0.27)), data)


def _draw_areas(axes: Axes, data: PlotData) -> None:
    limits: Dict[int, List[str]] = {}
    for number, color in enumerate(data.colors):
        axes.plot(data.areas[:, 0], data.areas[:, 1 + number], color=line_color(color.hue),
                  label=color.name)
        if color.area_limit_px is not None:
            limits.setdefault(color.area_limit_px, []).append(color.name)
    for limit_px, names in limits.items():
        axes.axhline(limit_px, color=_FAINT, linestyle='--', linewidth=1,
                     label='limit of {}: {} px'.format(
                         ', '.join(names) if len(names) <= _MAX_NAMES
                         else '{} colors'.format(len(names)), limit_px))
    # leaves space for the legend
    scales = ((2 * _LEGEND_COLUMNS, 1.8), (_LEGEND_COLUMNS, 1.4), (-1, 1.0))
    top = axes.get_ylim()[1] * next(scale for count, scale in scales if len(axes.lines) > count)
    axes.set_ylim(0, top)
    _set_title(axes, 'Area of each color')
    axes.set_ylabel('area (px)')
    if top > _MAX_TICK_PX:
        axes.yaxis.set_major_formatter(FuncFormatter(lambda area, _: '{:g}'.format(area / 1000)))
        axes.set_ylabel('area (1000 px)')
    _finish(axes)


def _draw_commands(axes: Axes, data: PlotData) -> None:
    commands, idle = data.commands, data.idle
    if len(idle):
        axes.plot(idle[:, 0], idle[:, 1], linestyle='', marker='|', markersize=6,
                  color=_FAINT, label='idle sender')
    axes.plot(commands[:, 0], commands[:, 1], linestyle='', marker='o', markersize=4,
              color=_LINEAR, label='linear.x')
    if commands[:, 2].any():
        axes.plot(commands[:, 0], commands[:, 2], linestyle='', marker='^', markersize=4,
                  color=_ANGULAR, label='angular.z')
    _set_title(axes, 'Commands')
    axes.set_ylabel('command (m/s, rad/s)' if commands[:, 2].any() else 'command (m/s)')
    axes.margins(y=0.15)
    _finish(axes)


def _draw_speed(axes: Axes, data: PlotData) -> None:
    rows = data.motion
    axes.plot(rows[:, TIME], rows[:, SPEED], color=_LINEAR, label='linear (left)')
    _two_scales(axes, rows[:, TIME], rows[:, TURN], 'angular (right)',
                ('linear (m/s)', 'angular (rad/s)'), 0.05)
    _set_title(axes, 'Speed of the robot')


def _draw_position(axes: Axes, data: PlotData) -> None:
    rows = data.motion
    for column, style, name in ((X, '-', 'x (left)'), (Y, ':', 'y (left)')):
        axes.plot(rows[:, TIME], rows[:, column] - rows[0, column], style, color=_LINEAR,
                  label=name)
    yaw = np.unwrap(rows[:, YAW])
    _two_scales(axes, rows[:, TIME], yaw - yaw[0], 'yaw (right)', ('x, y (m)', 'yaw (rad)'),
                0.01)
    _set_title(axes, 'Way from the start')


def _two_scales(axes: Axes, times: np.ndarray, angles: np.ndarray, name: str,
                labels: Tuple[str, str], min_range: float) -> None:
    """Draw angles with a separate scale, to the right of the scale in meters.

    name: of the line; labels: of the left and right scale.
    min_range: the left scale goes at least this far, so that the noise of a standing robot does
    not fill the plot.
    """
    right = axes.twinx()
    right.plot(times, angles, color=_ANGULAR, linewidth=1, label=name)
    axes.set_zorder(right.get_zorder() + 1)
    axes.patch.set_visible(False)       # it would hide the other axes
    for side, label, color, min_value in ((axes, labels[0], _LINEAR, min_range),
                                          (right, labels[1], _ANGULAR, 10 * min_range)):
        side.set_ylabel(label, color=color)
        max_value = max(np.abs(line.get_ydata()).max() for line in side.lines)
        side.set_ylim(*np.array((-1.15, 1.15)) * max(min_value, max_value))
    _finish(axes, axes.lines + right.lines)


def _draw_map(axes: Axes, data: PlotData) -> None:
    _draw_path(axes, data)
    axes.autoscale_view()
    axes.invert_xaxis()
    _set_title(axes, 'Path in the world')


def _draw_close_up(axes: Axes, data: PlotData) -> None:
    _draw_path(axes, data)
    rows = data.motion
    low, high = rows[:, X:YAW].min(axis=0), rows[:, X:YAW].max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    half += max(_MIN_MARGIN_M, 0.2 * half)
    # auto: the equal scales extend one of the two, and matplotlib 3.10 warns if it is fixed
    axes.set_ylim(middle[0] - half, middle[0] + half, auto=True)
    axes.set_xlim(middle[1] + half, middle[1] - half, auto=True)
    axes.ticklabel_format(useOffset=False)
    _set_title(axes, 'Close up')
    _finish(axes, axes.lines[-2:])


def _draw_path(axes: Axes, data: PlotData) -> None:
    # x is up and y is left, as in the picture of the simulation from above
    axes.set_aspect('equal', 'datalim')
    for outline in data.outlines:
        axes.add_patch(Polygon(outline[:, ::-1], facecolor=_WALL, edgecolor=_WALL, linewidth=0.5))
    for part in np.split(data.motion, data.moved):
        axes.plot(part[:, Y], part[:, X], color=_DARK, linewidth=1.2)
    x, y, yaw = data.motion[:, X], data.motion[:, Y], data.motion[:, YAW]
    position = 'end: {:.3f} m, {:.3f} m'.format(x[-1], y[-1])
    for row, color, size, name in ((0, _START, 14, 'start'), (-1, _LAST, 8, position)):
        axes.plot(y[row], x[row], linestyle='', color=color, markersize=size,
                  marker=(3, 0, np.degrees(yaw[row])), label=name)
    axes.set_xlabel('y (m)')
    axes.set_ylabel('x (m)')
    axes.grid(True, linewidth=0.3)


def _set_title(axes: Axes, title: str) -> None:
    # fixed y: finding a free height takes a quarter of the whole time
    axes.set_title(title, loc='left', y=1.0)


def _finish(axes: Axes, lines: Sequence = ()) -> None:
    axes.grid(True, linewidth=0.3)
    shown = list(lines) or axes.lines
    if len(shown) > _LEGEND_COLUMNS:
        axes.legend(handles=shown, loc='upper right', ncol=_LEGEND_COLUMNS, fontsize=8)
    else:
        axes.legend(handles=shown, loc='lower right', bbox_to_anchor=(1, 1), ncol=_LEGEND_COLUMNS,
                    frameon=False, fontsize=9, borderaxespad=0.1)


def line_color(hue: Tuple[int, int]) -> Tuple[float, float, float]:
    """Return the middle of a range of hues as RGB from 0 to 1.

    >>> [round(part, 2) for part in line_color((170, 10))]
    [0.8, 0.12, 0.12]
    """
    low, high = hue
    middle = (low + (high if high >= low else high + 180)) / 2 % 180
    return colorsys.hsv_to_rgb(middle / 180, 0.85, 0.8)
