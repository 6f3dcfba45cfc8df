"""What a page does with the colors of a robot."""
import dataclasses
import threading

import pytest
import rospy
import yaml

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web import tuning
from img_recog.nodes.web.tuning import ColorTuning
from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import with_colors


class Colors(ColorTuning):
    """With parameters and answers to is_settled that come one after the other."""

    def __init__(self, values=(), settled=()):
        super().__init__('/one/color_extract')
        self._told, self._settled = iter(values), iter(settled)
        self.last, self.changed = {'blue_hue_min': 50}, {}

    def values(self):
        return next(self._told, self.last)

    def is_settled(self):
        self.last = {'blue_hue_min': self.last['blue_hue_min'] + 1}
        return next(self._settled, True)

    def change(self, **values):
        self.changed.update(values)


@pytest.fixture(autouse=True)
def given(monkeypatch):
    """The parameters of the node on the master."""
    found = {}
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: found or default)
    return found


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


def test_the_file_gives_the_same_node(tmp_path, monkeypatch, given):
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    settings = with_colors(['blue', 'light_green'])(
        light_green_hue_min=40, light_green_hue_max=80, blue_linear_x=1e-7, stop_when_lost=0.5,
        publish_commands='sum')
    at_start = {'blue_image_topic': '/seen/yes', 'light_green_image_topic': 'on',
                'image_transport': 'compressed', 'max_image_pixels': 1000000}
    values = dataclasses.asdict(settings)
    # colors_file is of the launch file; the node has warned of the others
    given.update({**values, **at_start, 'colors': ['blue', 'light_green'], 'blue_linear_x': 0,
                  'colors_file': '/a/b.yaml', 'hue_mim': 3, 'red_image_topic': 'red'})
    path = Colors(values=[values]).save()
    assert dataclasses.asdict(parameter_file.read(path)) == values
    assert saved(path) == {**values, **at_start, 'colors': ['blue', 'light_green']}


def test_no_file_without_a_master(tmp_path, monkeypatch):
    def fail(*_):
        raise ConnectionRefusedError(111, 'Connection refused')
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    monkeypatch.setattr(rospy, 'get_param', fail)
    with pytest.raises(UserError, match='/one/color_extract does not answer; start it'):
        Colors().save()
    assert list(tmp_path.iterdir()) == []


def test_what_was_changed_can_be_changed_back():
    colors = Colors()
    before = colors.replace({'blue_hue_min': 100})
    assert before == {'blue_hue_min': 50} and colors.changed == {'blue_hue_min': 100}


@pytest.mark.parametrize('missing', [{'settled': 1000 * [False]}, {'values': 1000 * [{}]}])
@pytest.mark.parametrize('action', [ColorTuning.save,
                                    lambda colors: colors.replace({'blue_hue_min': 100})])
def test_changes_that_cannot_be_sent_are_not_left_out_in_silence(monkeypatch, missing, action):
    monkeypatch.setattr(tuning, 'ANSWER_TIMEOUT_S', 0.2)
    with pytest.raises(UserError, match='/one/color_extract does not answer; start it'):
        action(Colors(**missing))
