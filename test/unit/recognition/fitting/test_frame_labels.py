"""Labels of pixels by regions and times, and samples that cannot be used."""
import cv2
import numpy as np
import pytest
from PIL import Image

from img_recog.recognition.fitting import sample_file
from img_recog.recognition.fitting.frame_labels import Labeler
from img_recog.recognition.fitting.histograms import COLOR, IN_VIEW, NOT, Label
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal

SHAPE = 10, 20
RED = '- {color: red, rectangle: [2, 3, 4, 5]}\n'
BLUE = '- {color: blue, frame: 1, polygon: [[10, 0], [19, 0], [19, 9]]}\n'


@pytest.fixture
def labels(tmp_path):
    """A function that labels a frame by a list of samples."""
    def labels(text, frame=0, time_s=0.0, unlabeled='other'):
        path = tmp_path / 's.yaml'
        path.write_text('unlabeled: {}\nsamples:\n{}'.format(unlabeled, text))
        found = sample_file.read(str(path))
        return Labeler(found, 'a.mp4').of(frame, time_s, SHAPE)
    return labels


def rectangle():
    inside = np.zeros(SHAPE, bool)
    inside[3:8, 2:6] = True
    return inside


def parts(found):
    hsv = np.arange(600).reshape(*SHAPE, 3)
    result = {}
    for label, pixels in found.parts(hsv):
        if pixels.size:
            result[label] = result.get(label, 0) + pixels.size // 3
    return result


def test_a_region_and_what_is_beside_it(labels):
    found = labels(RED + BLUE)
    assert found.is_in_view == (True, False) and found.has_regions is True
    red, not_red = found.truth(0)
    assert (red == rectangle()).all() and (not_red == ~rectangle()).all()
    assert found.truth(1)[0].sum() == 0 and found.truth(1)[1].all()
    assert parts(found) == {Label(COLOR, 'red', ('red',)): 20, Label(NOT, '', ('red',)): 180}
    assert labels(RED + BLUE, frame=1).truth(1)[0].sum() > 50


def test_unlabeled_pixels_can_be_left_out(labels):
    found = labels(RED + BLUE + '- {color: none, rectangle: [0, 0, 1, 1]}\n', unlabeled='ignored')
    assert found.is_in_view == (True, None)
    assert found.truth(0)[1].sum() == 1 and found.truth(1)[1].sum() == 21
    assert parts(found) == {Label(COLOR, 'red', ('red',)): 20, Label(NOT, '', ('red',)): 1}


def test_what_is_ignored_is_so_in_a_region_too(labels):
    found = labels('- {color: ignored, rectangle: [2, 3, 4, 1]}\n' + RED)
    assert parts(found) == {Label(COLOR, 'red', ('red',)): 16, Label(NOT, '', ('red',)): 180}


@pytest.mark.parametrize('ignored', ['[0, 0, 20, 10]', '[2, 3, 4, 5]'])
def test_a_sample_that_is_all_ignored_is_refused(labels, ignored):
    assert 's.yaml: entry 1: all of it is in a part of the frame that is ignored; make' in refusal(
        labels, '{}- {{color: ignored, rectangle: {}}}\n'.format(RED, ignored))


def test_times_in_which_a_color_is_in_view_or_not(labels):
    text = '- {color: red, in_view: [0, 1]}\n- {color: blue, not_in_view: [0.5, 2]}\n' + BLUE
    assert parts(labels(text, 7, 0.2)) == {Label(IN_VIEW, 'red', ('red',)): 200}
    assert parts(labels(text, 7, 0.5)) == {Label(NOT, 'blue', ('red',)): 200,
                                           Label(IN_VIEW, 'red', ('red',)): 200}
    assert parts(labels(text, 7, 1.0)) == {Label(NOT, 'blue', ()): 200}
    empty = labels(text, 7, 2.0)
    assert empty.is_empty and parts(empty) == {} and empty.has_regions is False
    # red is somewhere in the frame, so what is not labeled may be red
    sampled = labels(text, 1, 0.2)
    assert sampled.is_in_view == (True, True)
    assert not sampled.truth(0)[1][9, 0] and sampled.truth(0)[1][0, 15]


def test_a_mask(labels, tmp_path):
    mask = np.zeros((*SHAPE, 4), np.uint8)
    mask[rectangle()] = (0, 0, 255, 255)
    cv2.imwrite(str(tmp_path / 'm.png'), mask)
    assert (labels('- {color: red, mask: m.png}\n').truth(0)[0] == rectangle()).all()


def test_samples_that_cannot_be_used(labels, tmp_path):
    cv2.imwrite(str(tmp_path / 'small.png'), np.full((4, 5), 255, np.uint8))
    cv2.imwrite(str(tmp_path / 'black.png'), np.zeros(SHAPE, np.uint8))
    (tmp_path / 'text.png').write_text('a letter')
    Image.new('L', SHAPE).save(str(tmp_path / 'gif.png'), 'GIF')
    expected.check_cases('refused/labels.txt', lambda text: refusal(labels, text).replace(
        '{}/'.format(tmp_path), ''))
