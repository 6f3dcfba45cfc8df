"""What the pictures of a film show."""
import os

import cv2
import numpy as np
import pytest

from img_recog.recognition.recognition_settings import with_colors
from img_recog.replay import film_picture
from img_recog.replay.film_picture import (HEIGHT, WIDTH, FilmPicture, line_colors,
                                           masks_grid)
from img_recog_helpers.figures import assert_unchanged
from img_recog_helpers.films import BLUE, PATH, ROBOT, SQUARE, card, center_of, draw

SETTINGS = with_colors()()
PAGE = (246, 244, 243)


def test_layout_is_as_it_was(tmp_path):
    film = FilmPicture(SETTINGS.colors, [SQUARE])
    film.scan = np.array([(3.9, 1.0), (3.9, 1.5), (2.0, 0.2)])
    for time_s in (0.0, 3.0, 6.5, 12.25):
        picture = draw(film, time_s, (0.5 + 0.1 * time_s, 2.0, 0.7),
                       areas_px=(4800 - int(300 * time_s), 90))
    assert_unchanged(picture, os.path.join(os.path.dirname(__file__), 'film.png'), tmp_path, 0)


def many_colors(count, hue=110):
    names = ['color_{}'.format(number) for number in range(count)]
    return with_colors(names)(**{
        '{}_hue_{}'.format(name, end): hue for name in names for end in ('min', 'max')}).colors


@pytest.mark.parametrize('count, columns', [(0, 1), (1, 1), (2, 1), (3, 1), (4, 2), (8, 2),
                                            (12, 3), (40, 6)])
def test_masked_images_of_many_colors_have_columns(count, columns):
    number, (width, height) = masks_grid(count, 4 / 3)
    assert number == columns
    rows = max(1, -(-count // number))
    assert number * width + (number - 1) * 10 <= 230 and rows * (height + 34) - 10 <= 384
    # the other masked images fill the column
    picture = draw(FilmPicture(many_colors(count), []), masked=[card()] * count,
                   areas_px=(4800,) * count)
    assert picture.shape == (HEIGHT, WIDTH, 3)
    blue = (picture[34:394, 500:730] == BLUE).all(axis=2)
    assert blue.any() == bool(count)


def test_without_colors_camera_and_speed_have_the_room_of_their_parts():
    film = FilmPicture([], [SQUARE])
    film.asked = 0.2
    picture = draw(film, masked=[], areas_px=())
    x, y = center_of(picture[34:394, 10:730], BLUE)
    assert (x, y) == pytest.approx((360, 180), abs=2)
    # both lower charts are one
    assert (picture[560, 10:1270] != PAGE).any(axis=1).all()


def test_lines_of_the_same_hue_have_different_colors():
    shown = [cv2.cvtColor(np.uint8([[color]]), cv2.COLOR_BGR2HSV)[0, 0, 0].astype(int)
             for color in line_colors(many_colors(8))]
    distances = [min((a - b) % 180, (b - a) % 180) for number, a in enumerate(shown)
                 for b in shown[:number]]
    assert shown[0] == 110 and min(distances) >= 13         # 15, rounded
    # more than there is room for
    assert len(line_colors(many_colors(20))) == 20


@pytest.mark.parametrize('pose, side', [((2.0, 2.0, 0.0), (0, 0)), ((3.5, 2.0, 1.0), (0, -1)),
                                        ((2.0, 0.5, -2.0), (1, 0))])
def test_the_robot_is_where_it_is_in_the_map(pose, side):
    picture = draw(FilmPicture(SETTINGS.colors, [SQUARE]), pose=pose)
    x, y = center_of(picture[34:394, 740:1270], ROBOT)
    scale = 360 / 4.6       # the square with its margin
    assert x - 265 == pytest.approx(side[0] * 1.5 * scale, abs=10)
    assert y - 180 == pytest.approx(side[1] * 1.5 * scale, abs=10)      # x is upward


def test_the_path_has_a_gap_where_the_robot_was_moved():
    film = FilmPicture(SETTINGS.colors, [SQUARE])
    for x, y in ((0.5, 0.5), (0.9, 0.5), (1.3, 0.5), (3.5, 3.5), (3.5, 3.1)):
        picture = draw(film, pose=(x, y, 0.0))
    path = (picture[34:394, 740:1270] == PATH).all(axis=2)
    scale = 360 / 4.6
    assert path[:, 265:].sum() == pytest.approx(0.8 * scale * 3, rel=0.3)
    assert path[:, :265].sum() > 0.2 * scale        # the robot covers the rest
    assert not path[180 - 20:180 + 20].any()        # between them


def test_without_odometry_there_is_no_robot():
    picture = draw(FilmPicture(SETTINGS.colors, []), pose=None)
    assert center_of(picture[34:394, 740:1270], ROBOT) is None


@pytest.mark.parametrize('driven, asked', [(0.1, 10.0), (0.1, -10.0), (4.0, 100.0)])
def test_commands_far_above_the_speed_do_not_make_its_line_flat(driven, asked):
    film = FilmPicture(SETTINGS.colors, [])
    for time_s, speed in ((0.0, 0.0), (1.0, driven)):
        film.pose, film.asked, film.driven = None, asked, speed
        picture = film.draw(time_s, card(), [], (0, 0))
    chart = picture[450:690, 800:1268].astype(int)
    rows = np.nonzero((abs(chart - (43, 142, 242)) < 3).all(axis=2))[0]
    assert np.ptp(rows) > 0.2 * len(chart)


def test_old_values_leave_the_charts():
    film = FilmPicture(SETTINGS.colors, [])
    for time_s in (0.0, 1.0, 30.0):
        picture = draw(film, time_s)
    assert np.array_equal(picture, draw(FilmPicture(SETTINGS.colors, []), 30.0))


@pytest.mark.parametrize('name, counts', [('name_{}', [3, 3, 2]), ('a_longer_name_{}', [2] * 4)])
def test_a_long_legend_has_several_rows(name, counts):
    picture = np.full((200, 400, 3), 255, np.uint8)
    lines = [(name.format(number), (0, 0, 200), []) for number in range(8)]
    film_picture.put_chart(picture, (0, 0, 400, 200), 'a chart', lines, 0.0, [])
    drawn = (picture == (0, 0, 200)).all(axis=2)
    assert [drawn[y].sum() for y in (32, 48, 64, 80)] == [23 * count for count in counts] + [0] * (
        4 - len(counts))
    assert not drawn[:, 389:].any()


def test_parts_look_the_same_wherever_they_are():
    lines = [('line_{}'.format(number), (200, 80, 8 * number), [
        (1.0, -3.0), (4.5, 2.0 * number), (9.0, 5.0)]) for number in range(5)]

    def drawn(left, top):
        picture = np.full((300, 700, 3), 255, np.uint8)
        film_picture.put_chart(picture, (left, top, 400, 180), 'a chart', lines, 9.5,
                               [(4.0, (0, 0, 200))])
        film_picture.put_image(picture, (left + 410, top, 100, 80), 'an image', card())
        return picture[top:top + 200, left:left + 530]
    assert all(np.array_equal(drawn(*place), drawn(0, 0)) for place in ((38, 57), (97, 71)))


@pytest.mark.parametrize('pose', [(-9.0, 2.0), (13.0, 2.0), (2.0, -9.0), (2.0, 13.0)])
def test_the_map_grows_with_the_path(pose):
    area = draw(FilmPicture(SETTINGS.colors, [SQUARE]), pose=(*pose, 0.0))[34:394, 740:1270]
    x, y = center_of(area, ROBOT)
    assert 5 < x < 525 and 5 < y < 355
