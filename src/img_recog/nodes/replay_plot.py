"""A replay in one picture: areas, commands and speed over time, and the path in the world."""
import colorsys
from typing import IO, Dict, List, Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from img_recog.nodes.replay_chain import RECOGNITION, SECOND_NS, TELEOP, Recorder, Seen, Sent
from img_recog.nodes.replay_records import yaw_of
from img_recog.recognition.settings import Color

_SIZE_IN, _DPI = (14.0, 8.0), 100
_DARK, _FAINT, _LINEAR, _ANGULAR = '#222222', '#999999', '#2ca02c', '#9467bd'
_START, _END = '#2ca02c', '#d62728'
_ROOM_M = 0.15                  # around a path
_SMALL = 0.25                   # of the world: a path that is shorter is shown enlarged as well


class PlotRecorder(Recorder):
    """Keeps what is drawn at the end: some numbers a frame.

    frames: how many have been seen.
    """

    def __init__(self, colors: Sequence[Color]):
        self._colors = colors
        self._rows: List[tuple] = []
        self._sent: Dict[str, List[tuple]] = {RECOGNITION: [], TELEOP: []}

    @property
    def frames(self) -> int:
        return len(self._rows)

    def seen(self, seen: Seen) -> None:
        motion = seen.motion
        self._rows.append((seen.time_ns / SECOND_NS, motion.position[0], motion.position[1],
                           yaw_of(motion), motion.linear[0], motion.angular[2], *seen.areas_px))

    def sent(self, sent: Sent) -> None:
        self._sent[sent.sender].append((sent.time_ns / SECOND_NS, *sent.command))

    def draw(self, file: IO[bytes], title: str, end_s: float,
             outlines: Sequence[np.ndarray]) -> None:
        """Write the picture as PNG.

        end_s: where the axis of time ends; outlines: (corners, 2) in m, of what is in the world.
        """
        # not as the user's own matplotlibrc has it
        with matplotlib.rc_context({**matplotlib.rcParamsDefault, 'font.size': 10.0}):
            figure = Figure(figsize=_SIZE_IN, dpi=_DPI, constrained_layout=True)
            FigureCanvasAgg(figure)
            figure.suptitle(title)
            grid = figure.add_gridspec(3, 2, width_ratios=(1.35, 1))
            first = figure.add_subplot(grid[0, 0])
            others = [figure.add_subplot(grid[row, 0], sharex=first) for row in (1, 2)]
            rows = np.array(self._rows)
            self._draw_areas(first, rows)
            self._draw_commands(others[0])
            _draw_speed(others[1], rows)
            first.set_xlim(0, max(end_s, 1e-3))
            for axes in (first, others[0]):
                axes.tick_params(labelbottom=False)
            others[1].set_xlabel('simulated time (s)')
            _draw_path(figure.add_subplot(grid[:, 1]), rows, outlines)
            figure.savefig(file, format='png')

    def _draw_areas(self, axes: Axes, rows: np.ndarray) -> None:
        limits: Dict[int, List[str]] = {}
        for number, color in enumerate(self._colors):
            axes.plot(rows[:, 0], rows[:, 6 + number], color=_shown(color), label=color.name)
            limits.setdefault(color.area_limit_px, []).append(color.name)
        for limit_px, names in limits.items():
            axes.axhline(limit_px, color=_FAINT, linestyle='--', linewidth=1,
                         label='limit of {}: {} px'.format(', '.join(names), limit_px))
        axes.set_ylim(bottom=0)
        axes.set_title('Area of each colour', loc='left')
        axes.set_ylabel('area (px)')
        _finish(axes)

    def _draw_commands(self, axes: Axes) -> None:
        teleop = np.array(self._sent[TELEOP]).reshape(-1, 3)
        if len(teleop):
            axes.plot(teleop[:, 0], teleop[:, 1], linestyle='', marker='|', markersize=6,
                      color=_FAINT, label='idle teleop, linear.x')
        found = np.array(self._sent[RECOGNITION]).reshape(-1, 3)
        axes.plot(found[:, 0], found[:, 1], linestyle='', marker='o', markersize=4,
                  color=_LINEAR, label='recognition, linear.x')
        if found[:, 2].any():
            axes.plot(found[:, 0], found[:, 2], linestyle='', marker='^', markersize=4,
                      color=_ANGULAR, label='recognition, angular.z')
        axes.set_title('Commands on /cmd_vel', loc='left')
        axes.set_ylabel('command (m/s, rad/s)' if found[:, 2].any() else 'command (m/s)')
        axes.margins(y=0.15)
        _finish(axes)


def _draw_speed(axes: Axes, rows: np.ndarray) -> None:
    lines = axes.plot(rows[:, 0], rows[:, 4], color=_LINEAR, label='linear (m/s, left)')
    axes.set_ylabel('linear (m/s)', color=_LINEAR)
    turning = axes.twinx()
    lines += turning.plot(rows[:, 0], rows[:, 5], color=_ANGULAR, linewidth=1,
                          label='angular (rad/s, right)')
    turning.set_ylabel('angular (rad/s)', color=_ANGULAR)
    for each, least in ((axes, 0.05), (turning, 0.5)):
        # the noise of a robot that stands is not to fill the picture
        largest = max(least, 1.15 * np.abs(each.lines[0].get_ydata()).max())
        each.set_ylim(-largest, largest)
    axes.set_title('Speed of the robot', loc='left')
    _finish(axes, lines)


def _draw_path(axes: Axes, rows: np.ndarray, outlines: Sequence[np.ndarray]) -> None:
    _draw_map(axes, rows, outlines)
    axes.set_title('Path in the world', loc='left')
    axes.set_xlabel('x (m)')
    axes.set_ylabel('y (m)')
    axes.autoscale_view()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    middle, half = _extent(rows)
    if 2 * half < _SMALL * max(right - left, high - low):
        closer = axes.inset_axes((0.56, 0.02, 0.42, 0.42 * (right - left) / (high - low)))
        _draw_map(closer, rows, outlines)
        closer.set_xlim(middle[0] - half, middle[0] + half)
        closer.set_ylim(middle[1] - half, middle[1] + half)
        closer.tick_params(labelsize=7)
        axes.indicate_inset_zoom(closer, edgecolor=_DARK)
    axes.legend(loc='upper left', framealpha=0.9)


def _draw_map(axes: Axes, rows: np.ndarray, outlines: Sequence[np.ndarray]) -> None:
    axes.set_aspect('equal', 'datalim' if not outlines else 'box')
    for outline in outlines:
        axes.add_patch(Polygon(outline, facecolor='#d0d0d0', edgecolor='#a0a0a0', linewidth=0.5))
    x, y, yaw = rows[:, 1], rows[:, 2], rows[:, 3]
    axes.plot(x, y, color=_DARK, linewidth=1.2, label='path')
    for row, color, label in ((0, _START, 'start'), (-1, _END, 'end')):
        axes.plot(x[row], y[row], linestyle='', color=color, markersize=10,
                  marker=(3, 0, np.degrees(yaw[row]) - 90), label='{}: x {:.2f} m, y {:.2f} m'
                  .format(label, x[row], y[row]))
    axes.grid(True, linewidth=0.3)


def _extent(rows: np.ndarray):
    """Return the middle (x, y) of the path and half the side of a square around it, in m."""
    low, high = rows[:, 1:3].min(axis=0), rows[:, 1:3].max(axis=0)
    return (low + high) / 2, (high - low).max() / 2 + _ROOM_M


def _finish(axes: Axes, lines: Sequence = ()) -> None:
    axes.grid(True, linewidth=0.3)
    axes.legend(handles=list(lines) or None, loc='lower right', bbox_to_anchor=(1, 1), ncol=4,
                frameon=False, fontsize=9, borderaxespad=0.1)


def _shown(color: Color) -> tuple:
    """Return the middle of a range of hues as red, green, blue from 0 to 1."""
    low, high = color.hue
    middle = (low + (high if high >= low else high + 180)) / 2 % 180
    return colorsys.hsv_to_rgb(middle / 180, 0.85, 0.8)
