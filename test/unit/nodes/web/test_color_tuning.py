"""What a page does with the colors of a robot."""
import threading

import pytest
import yaml

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web import color_tuning
from img_recog.nodes.web.color_tuning import ColorTuning


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


def test_what_was_changed_can_be_changed_back():
    colors = Colors()
    before = colors.replace({'blue_hue_min': 100})
    assert before == {'blue_hue_min': 50} and colors.changed == {'blue_hue_min': 100}


@pytest.mark.parametrize('missing', [{'settled': 1000 * [False]}, {'values': 1000 * [{}]}])
@pytest.mark.parametrize('action', [ColorTuning.save,
                                    lambda colors: colors.replace({'blue_hue_min': 100})])
def test_changes_that_cannot_be_sent_are_not_left_out_in_silence(monkeypatch, missing, action):
    monkeypatch.setattr(color_tuning, '_ANSWER_TIMEOUT_S', 0.2)
    with pytest.raises(UserError, match='/one/color_extract does not answer; start it'):
        action(Colors(**missing))
