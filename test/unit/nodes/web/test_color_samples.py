"""The samples that all pages of a robot share, with stand-ins for its pictures and the search."""
import os
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web import color_samples, tuning
from img_recog.nodes.web.color_samples import ColorSamples
from img_recog.recognition.fitting.marked import Marked
from img_recog.recognition.fitting.offers import Offer
from img_recog_helpers.waiting import wait_for

RECTANGLE = 0.1, 0.1, 0.3, 0.3


@pytest.fixture
def search(monkeypatch):
    """The search: numbers of the samples that it was given; it waits for `may_end`."""
    found = SimpleNamespace(given=[], may_end=threading.Event())

    def offers(marked, timeout_s):
        found.given.append([each.number for each in marked.samples])
        assert found.may_end.wait(timeout_s)
        if len(marked.samples) > 3:
            raise OSError('no memory')
        if len(marked.samples) > 2:
            raise UserError('too many', 'mark fewer')
        return {color: Offer(None, problem='as a test') for color in marked.colors}
    monkeypatch.setattr(color_samples, 'offers_of_a_process', offers)
    found.may_end.set()
    return found


@pytest.fixture
def samples(search, tmp_path, monkeypatch):
    """Samples that are saved to a folder."""
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    image = np.full((60, 80, 3), (40, 30, 190), np.uint8)
    return ColorSamples('/camera', SimpleNamespace(
        latest=lambda topic: topic, image=lambda topic: image))


def searched(samples):
    wait_for(lambda: not samples.state.is_searching, 'the end of the search')
    return samples.state


def test_a_mark_holds_the_picture_and_bounds_are_searched(samples):
    name = samples.mark('', 'red', *RECTANGLE)
    assert samples.mark(name, 'none', 0.9, 0.9) == name
    assert list(searched(samples).offers) == ['red']
    jpeg, lines = samples.shown(name)
    assert jpeg.startswith(b'\xff\xd8') and len(lines) == 2
    for number in (1, 2):
        samples.remove(number)
    assert searched(samples).offers == {} and samples.shown(name)[1] == []


def test_what_changes_during_a_search_is_searched_afterwards(samples, search):
    search.may_end.clear()
    name = samples.mark('', 'red', *RECTANGLE)
    wait_for(lambda: search.given, 'the search')
    samples.mark(name, 'red', *RECTANGLE)
    samples.set_rest(False)
    assert samples.state.is_searching and samples.state.offers == {}
    search.may_end.set()
    assert list(searched(samples).offers) == ['red'] and search.given[-1] == [1, 2]
    samples.mark(name, 'red', *RECTANGLE)
    assert searched(samples).problem == 'too many; mark fewer' and not samples.state.offers
    samples.mark(name, 'red', *RECTANGLE)
    assert searched(samples).problem == 'no memory' and not samples.state.offers


def test_a_refused_mark_changes_nothing(samples):
    name = samples.mark('', 'red', *RECTANGLE)
    before = searched(samples)
    with pytest.raises(UserError, match='outside of the picture'):
        samples.mark(name, 'red', 2.0, 0.5)
    assert samples.state is before


def test_without_a_picture(search, monkeypatch):
    monkeypatch.setattr(tuning, 'ANSWER_TIMEOUT_S', 0.1)
    samples = ColorSamples('/camera', SimpleNamespace(
        latest=lambda topic: None, image=lambda topic: None))
    with pytest.raises(UserError, match='there is no picture of /camera; try again'):
        samples.mark('', 'red', 0.5, 0.5)


def test_they_are_saved_once_to_a_folder_that_is_free(samples, tmp_path):
    with pytest.raises(UserError, match='there is no sample of a color'):
        samples.save()
    (tmp_path / 'samples_1').mkdir()
    name = samples.mark('', 'red', *RECTANGLE)
    path = samples.save()
    assert path == samples.save() == str(tmp_path / 'samples_2')
    assert sorted(os.listdir(path)) == ['masks', name, 'samples.yaml']
    samples.set_rest(False)
    assert samples.save() == str(tmp_path / 'samples_3')


def test_nothing_is_left_of_what_cannot_be_saved(samples, tmp_path, monkeypatch):
    def write(marked, folder):
        os.mkdir(os.path.join(folder, 'masks'))
        raise OSError(28, 'No space left on device')
    monkeypatch.setattr(color_samples.marked, 'write', write)
    samples.mark('', 'red', *RECTANGLE)
    with pytest.raises(UserError, match='samples_1: no space left on device; start it in a'):
        samples.save()
    assert os.listdir(str(tmp_path)) == []


def test_a_search_in_a_process():
    assert color_samples.offers_of_a_process(Marked(), 300) == {}


@pytest.mark.parametrize('timeout_s, problem', [
    (0.0, 'took more than 0 s; mark fewer pictures'),
    (300, 'has ended: exit code 1; see the log of the page')])
def test_a_search_without_result_is_named(monkeypatch, timeout_s, problem):
    monkeypatch.setattr(color_samples, '_send_offers', os.getpid)   # takes no arguments
    with pytest.raises(UserError, match=problem):
        color_samples.offers_of_a_process(Marked(), timeout_s)
