"""The picture of a replay: what is in it, where, and how it looks."""
import io
import os

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure

from img_recog.recognition.recognition_settings import with_colors
from img_recog.replay import figure
from img_recog.replay.plot_data import PlotData
from img_recog_helpers.figures import assert_unchanged, of_matplotlib

TWO = with_colors()(red_area_limit=400).colors
FIVE = with_colors(['blue', 'red', 'c', 'd', 'e'])(
    c_hue_min=170, c_hue_max=10, d_hue_min=1, d_hue_max=4, e_hue_min=20, e_hue_max=21).colors
# the areas of NINE are numbers that are too long for the axis
NAMES = ['color_{}'.format(number) for number in range(9)]
NINE = with_colors(NAMES)(color_0_area_limit=400_000, **{
    '{}_hue_{}'.format(name, end): 20 * number for number, name in enumerate(NAMES)
    for end in ('min', 'max')}).colors
SQUARE = np.array([(1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0)])


def rows(colors, turns=True):
    """Return rows of a drive along an arc, through a yaw of pi, or of a robot that stands."""
    times = np.arange(6) / 25.0
    yaw = np.array((3.0, 3.1, -3.1, -3.0, -2.8, -2.5)) if turns else np.ones(6)
    way = np.arange(6) * (0.3 if turns else 0.0)
    areas = [500.0 * number * (1 + np.arange(6) % 3) for number in range(1, len(colors) + 1)]
    return np.stack([times, -2 + way, 0.5 * way, yaw, 0.5 * way, 0.2 * way, *areas], axis=1)


def drawn(colors):
    file, all_rows = io.BytesIO(), rows(TWO)
    all_rows[:, 1] += 1e5
    data = PlotData(
        colors, all_rows[:, :6], np.delete(all_rows, range(1, 6), 1)[:, :1 + len(colors)],
        np.empty((0, 3)), np.empty((0, 3)), 0.24, [])
    figure.draw(file, 'a test', data)
    picture = Figure()
    figure.draw_on(picture, 'a test', data)
    picture.canvas.draw()
    close_up, = (axes for axes in picture.axes if axes.get_title('left') == 'Close up')
    assert close_up.yaxis.get_offset_text().get_text() == ''        # numbers are whole ones
    return cv2.imdecode(np.frombuffer(file.getvalue(), np.uint8), cv2.IMREAD_GRAYSCALE)


def test_without_colors_the_other_charts_have_the_room_of_the_areas():
    heights = []
    for colors in ((), TWO):
        # the dark left edges of the charts
        edge = drawn(colors)[:, 83:86].min(axis=1) < 100
        ends = np.flatnonzero(np.diff(np.concatenate(([0], edge, [0]))))
        lengths = ends[1::2] - ends[::2]
        heights.append(lengths[lengths > 50].tolist())      # the others are letters
    assert [len(each) for each in heights] == [3, 4]
    assert min(heights[0]) > 1.2 * max(heights[1])


@pytest.mark.parametrize('name, colors, turns, recognition, teleop, outlines', [
    ('replay_two', TWO, True, [(0.0, 10.0, 0.0), (0.1, -10.0, 0.5)], [(0.05, 0.0, 0.0)],
     [SQUARE, -SQUARE]),
    ('replay_five', FIVE, False, [(0.0, 10.0, 0.0)], [], []),
    ('replay_nine', NINE, False, [(0.0, 10.0, 0.0)], [], [])])
def test_layout_is_as_it_was(name, colors, turns, recognition, teleop, outlines, tmp_path):
    file = io.BytesIO()
    drawn_rows = rows(colors, turns)
    figure.draw(file, 'a test', PlotData(
        colors, drawn_rows[:, :6], np.delete(drawn_rows, range(1, 6), 1),
        np.reshape(recognition, (-1, 3)), np.reshape(teleop, (-1, 3)), 0.24, outlines))
    assert_unchanged(of_matplotlib(file.getvalue()),
                     os.path.join(os.path.dirname(__file__), name + '.png'), tmp_path)
