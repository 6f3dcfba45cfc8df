"""The colors of config/follow.yaml and those of the article, on a camera of the simulated robot.

Offline: the same recognition, commands and simulation as in the demo, and as in replay.py.
"""
import math

import numpy as np
import pytest

from img_recog.recognition.commands import STOP
from img_recog_testing.following import FOLLOW, Drive

BLUE = ('blue_post_1', 'blue_post_2')
POSTS = {'blue_post_1': (0.5, -0.15), 'blue_post_2': (1.5, 2.5), 'red_post_1': (-3.4, -0.5),
         'red_post_2': (2.5, -3.4)}
JITTER = (0, 2, 1, 0, 0, 2, 2, 1)


def assert_stands_before(drive, name, nearest=0.4, farthest=0.55, posts=None):
    """Check that the robot has come to rest before a post and has touched nothing."""
    assert drive.contacts == set()
    assert drive.rest_s() > 1.0 and drive.results[-1].commands[-1] == STOP
    assert nearest < drive.gap(name) < farthest
    for name, place in {**POSTS, **(posts or {})}.items():
        assert drive.models.state(name).position[:2] == pytest.approx(place, abs=0.002), name


@pytest.mark.parametrize('x, y, yaw, size, delays, name', [
    (-1.0, -1.2, -0.6, (160, 120), (1,), 'blue_post_1'),
    (1.2, 0.9, 1.9, (160, 120), (2,), 'blue_post_2'),
    # beside a wall, and beside a red post
    (2.8, 3.8, 3.0, (160, 120), JITTER, 'blue_post_2'),
    (-1.0, 0.1, -2.6, (160, 120), JITTER, 'blue_post_1')])
def test_the_robot_finds_a_blue_post_and_stops_before_it(x, y, yaw, size, delays, name):
    posts = {'red_post_1': (-1.3, 0.1)}
    drive = Drive(x, y, yaw, posts, size=size, delays=delays).run(24.0)
    assert_stands_before(drive, name, posts=posts)


@pytest.mark.parametrize('distance, bearing, seconds', [
    (0.22, 0.0, 4.0), (0.24, 1.2, 8.0), (0.35, -0.5, 16.0)])
def test_a_post_that_is_near_at_the_start_is_not_touched(distance, bearing, seconds):
    posts = {'blue_post_1': (distance * math.cos(bearing), distance * math.sin(bearing))}
    drive = Drive(0.0, 0.0, 0.0, posts, delays=JITTER)
    begin = drive.gap('blue_post_1')
    drive.run(seconds)
    assert_stands_before(drive, 'blue_post_1', begin - 0.01, begin + 0.06, posts)


@pytest.mark.parametrize('aside', [0.0, 0.12])
def test_a_red_post_in_the_way_is_not_touched(aside):
    posts = {'red_post_1': (-0.8, aside), 'blue_post_1': (0.5, 0.0)}
    drive = Drive(-1.6, 0.0, 0.0, posts, delays=JITTER).run(16.0)
    assert drive.contacts == set()
    assert drive.models.state('red_post_1').position[:2] == pytest.approx((-0.8, aside), abs=0.002)


def test_the_robot_follows_a_post_that_is_moved():
    x, y = 0.0, -0.5

    def place(time_s):
        """Away for 6 s at 0.15 m/s, a pause, and aside."""
        return (x + 0.15 * min(max(time_s - 4.0, 0.0), 6.0),
                y + 0.15 * min(max(time_s - 16.0, 0.0), 4.0))
    drive = Drive(-1.0, -0.5, 0.0, {'blue_post_1': (x, y)}, delays=JITTER)
    gaps = {}

    def at_frame(time_s):
        drive.move('blue_post_1', *place(time_s))
        gaps[time_s] = drive.gap('blue_post_1')
    drive.run(26.0, at_frame)
    assert_stands_before(drive, 'blue_post_1', posts={'blue_post_1': place(26.0)})
    before, between = (min((gap for time_s, gap in gaps.items() if abs(time_s - at_s) < 0.02))
                       for at_s in (4.0, 15.5))
    assert 0.4 < before < 0.55 and 0.4 < between < 0.55
    assert min(gaps.values()) > 0.4 and drive.results[-1].motion.position[0] > 0.2
    ahead = drive.results[-1].motion
    x, y = place(26.0)
    bearing = math.atan2(y - ahead.position[1], x - ahead.position[0]) - ahead.yaw
    assert abs(bearing) < 0.2


def test_without_the_near_colors_the_post_is_touched(tmp_path):
    """The contacts are really found."""
    with open(FOLLOW) as file:
        text = file.read()
    path = tmp_path / 'no_stop.yaml'
    path.write_text(text.replace('near_row_min: 0.85', 'near_row_min: 1.0').replace(
        'left_row_min: 0.85', 'left_row_min: 1.0').replace(
        'right_row_min: 0.85', 'right_row_min: 1.0'))
    drive = Drive(-0.3, -0.15, 0.0, colors=str(path)).run(6.0)
    assert drive.contacts == {'blue_post_1'}


def test_the_colors_of_the_article_drive_to_blue_until_it_is_out_of_the_picture():
    drive = Drive(-2.0, -0.5, 0.0, colors='', teleop=True, size=(640, 480)).run(6.0)
    seen = [result for result in drive.results if result.areas_px[0] > 1000]
    assert seen == drive.results[:len(seen)] and len(seen) > 60
    assert all(result.commands == [(10.0, 0.0)] for result in seen)
    assert all(result.commands == [] for result in drive.results[len(seen):])
    areas_px = [result.areas_px[0] for result in seen]
    places = [result.motion.position[0] for result in seen]
    assert max(areas_px) > 4 * areas_px[0] and np.all(np.diff(places[10:]) > 0)
    # beside the post; then the teleop stops it
    assert -0.4 < places[-1] < 0.2 and drive.results[-1].areas_px[0] == 0
    assert drive.rest_s() > 0.5 and drive.contacts == set()


def test_the_colors_of_the_article_drive_away_from_red_until_it_is_small():
    drive = Drive(-2.0, -0.5, math.pi, colors='', teleop=True, size=(640, 480)).run(3.3)
    seen = [result for result in drive.results if result.areas_px[1] > 1000]
    assert seen == drive.results[:len(seen)] and len(seen) > 60
    assert all(result.commands == [(-10.0, 0.0)] for result in seen)
    assert all(result.commands == [] for result in drive.results[len(seen):])
    assert np.all(np.diff([result.motion.position[0] for result in seen[10:]]) > 0)
    assert seen[0].areas_px[1] > 4000 and seen[-1].motion.position[0] > -0.6
    assert drive.contacts == set()
