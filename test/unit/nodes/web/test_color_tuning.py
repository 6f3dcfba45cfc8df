"""What a page does with the colors of a robot."""
import threading

import cv2
import numpy as np
import pytest
import yaml

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web import color_tuning
from img_recog.nodes.web.color_tuning import ColorTuning
from img_recog.nodes.web.pictures import Picture

TOPIC, BLUE = '/usb_cam/image_raw', (215, 70, 25)


class Colors(ColorTuning):
    """With pictures, parameters and answers to is_settled that come one after the other."""

    def __init__(self, pictures=(), values=(), settled=()):
        super().__init__('/one/color_extract', self)
        self._shown, self._told, self._settled = iter(pictures), iter(values), iter(settled)
        self.last, self.changed = {'blue_hue_min': 50}, {}

    def latest(self, topic):
        assert topic == TOPIC
        return next(self._shown, blue_picture())

    def values(self):
        return next(self._told, self.last)

    def is_settled(self):
        self.last = {'blue_hue_min': self.last['blue_hue_min'] + 1}
        return next(self._settled, True)

    def change(self, **values):
        self.changed.update(values)


def blue_picture():
    image = np.full((240, 320, 3), BLUE, np.uint8)
    return Picture(1, cv2.imencode('.jpg', image)[1].tobytes())


def saved(path):
    with open(path) as file:
        return yaml.safe_load(file)


def test_robots_save_their_colors_at_once_with_the_last_changes(tmp_path, monkeypatch):
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    paths = {}

    def save(number):
        paths[number] = Colors(settled=number * [False]).save()
    threads = [threading.Thread(target=save, args=(number,)) for number in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(paths.values())) == 20
    for number, path in paths.items():
        assert saved(path) == {'colors': ['blue'], 'blue_hue_min': 51 + number}


def test_a_click_waits_until_the_picture_and_the_parameters_are_followed_again():
    colors = Colors([None, None], [{}, {}])
    bounds = colors.propose(TOPIC, 0.5, 0.5, 'blue')
    hue = int(cv2.cvtColor(np.uint8([[BLUE]]), cv2.COLOR_BGR2HSV)[0, 0, 0])
    assert bounds['hue_min'] == pytest.approx(hue - 10, abs=1)
    assert colors.changed == {'blue_' + part: value for part, value in bounds.items()}


@pytest.mark.parametrize('missing, problem', [
    ({'pictures': 1000 * [None]},
     'there is no picture of /usb_cam/image_raw; click again when there is one'),
    ({'values': 1000 * [{}]}, '/one/color_extract does not answer; start it')])
def test_what_is_missing_after_a_moment_is_named(monkeypatch, missing, problem):
    monkeypatch.setattr(color_tuning, '_ANSWER_TIMEOUT_S', 0.2)
    colors = Colors(**missing)
    with pytest.raises(UserError) as error:
        colors.propose(TOPIC, 0.5, 0.5, 'blue')
    assert str(error.value) == problem and colors.changed == {}


@pytest.mark.parametrize('missing', [{'settled': 1000 * [False]}, {'values': 1000 * [{}]}])
def test_changes_that_cannot_be_sent_are_not_left_out_in_silence(monkeypatch, missing):
    monkeypatch.setattr(color_tuning, '_ANSWER_TIMEOUT_S', 0.2)
    with pytest.raises(UserError, match='/one/color_extract does not answer; start it'):
        Colors(**missing).save()
