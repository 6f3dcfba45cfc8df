"""The picture of a replay: what is in it, where, and how it looks."""
import io
import os

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


def test_without_colors_the_other_charts_have_the_room_of_the_areas():
    heights = []
    for colors in ((), TWO):
        picture, moved = Figure(), rows(TWO)
        moved[:, 1] += 1e5
        figure.draw_on(picture, 'a test', PlotData(
            colors, moved[:, :6], np.delete(moved, range(1, 6), 1)[:, :1 + len(colors)],
            np.empty((0, 3)), np.empty((0, 3)), 0.24, []))
        charts = {axes.get_title('left'): axes for axes in picture.axes}
        heights.append([charts[title].get_position().height
                        for title in ('Commands', 'Speed of the robot', 'Way from the start')])
    assert min(heights[0]) > 1.2 * max(heights[1])
    picture.canvas.draw()
    # numbers are whole ones
    assert charts['Close up'].yaxis.get_offset_text().get_text() == ''


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
