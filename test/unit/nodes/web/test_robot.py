"""What a page does with the colors of its robot."""
import threading
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import yaml

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web import robot as robots
from img_recog.nodes.web.feed import Picture
from img_recog.nodes.web.robot import Robot


def test_two_robots_save_their_colors_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    saved = {}

    def save(number):
        robot = Robot.__new__(Robot)
        robot.colors = SimpleNamespace(
            values=lambda: {'blue_hue_min': number}, is_settled=lambda: True)
        saved[number] = robot.save_colors()
    threads = [threading.Thread(target=save, args=(number,)) for number in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(saved.values())) == 20
    for number, path in saved.items():
        with open(path) as file:
            assert yaml.safe_load(file) == {'colors': ['blue'], 'blue_hue_min': number}


def test_changes_that_are_not_sent_yet_are_waited_for_and_saved(tmp_path, monkeypatch):
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    values, settled = {'blue_hue_min': 1}, iter([False, False, True])

    def is_settled():
        values['blue_hue_min'] += 1
        return next(settled)
    robot = robot_with(None, SimpleNamespace(values=lambda: dict(values), is_settled=is_settled))
    with open(robot.save_colors()) as file:
        assert yaml.safe_load(file) == {'colors': ['blue'], 'blue_hue_min': 4}


def test_changes_that_cannot_be_sent_are_not_left_out_in_silence(monkeypatch):
    monkeypatch.setattr(robots, '_ANSWER_TIMEOUT_S', 0.2)
    robot = robot_with(None, SimpleNamespace(values=lambda: {'blue_hue_min': 1},
                                             is_settled=lambda: False))
    with pytest.raises(UserError, match='/one/color_extract does not answer; start it'):
        robot.save_colors()


class Colors:
    """Parameters that come after some looks, and the changes."""

    def __init__(self, looks):
        self._looks, self.changed = looks, {}

    def values(self):
        self._looks -= 1
        return {'blue_hue_min': 50} if self._looks < 0 else {}

    def change(self, **values):
        self.changed.update(values)


def robot_with(pictures, colors):
    """A robot whose pictures are those of an iterator."""
    robot = Robot.__new__(Robot)
    robot.name, robot.colors = 'one', colors
    robot._pictures = SimpleNamespace(latest=lambda topic: next(pictures))
    return robot


def blue_picture():
    image = np.full((240, 320, 3), (215, 70, 25), np.uint8)
    return Picture(1, cv2.imencode('.jpg', image)[1].tobytes())


def test_a_click_waits_until_the_picture_and_the_parameters_are_followed_again():
    colors = Colors(looks=2)
    bounds = robot_with(iter([None, None, blue_picture()]), colors).propose(
        '/usb_cam/image_raw', 0.5, 0.5, 'blue')
    hue = int(cv2.cvtColor(np.uint8([[(215, 70, 25)]]), cv2.COLOR_BGR2HSV)[0, 0, 0])
    assert bounds['hue_min'] == pytest.approx(hue - 10, abs=1)
    assert colors.changed == {'blue_' + part: value for part, value in bounds.items()}


@pytest.mark.parametrize('picture, looks, problem', [
    (None, 0, 'there is no picture of /usb_cam/image_raw; click again when there is one'),
    (blue_picture(), 1000, '/one/color_extract does not answer; start it')])
def test_what_is_missing_after_a_moment_is_named(monkeypatch, picture, looks, problem):
    monkeypatch.setattr(robots, '_ANSWER_TIMEOUT_S', 0.2)
    colors = Colors(looks)
    with pytest.raises(UserError) as error:
        robot_with(iter(lambda: picture, 0), colors).propose(
            '/usb_cam/image_raw', 0.5, 0.5, 'blue')
    assert str(error.value) == problem and colors.changed == {}
