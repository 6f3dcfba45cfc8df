"""Files of samples: what is read, and what is refused with its entry."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.fitting import sample_file
from img_recog.recognition.fitting.samples import SampleError
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal


@pytest.fixture
def read(tmp_path):
    """A function that reads a text as a file of samples."""
    def read(text):
        (tmp_path / 's.yaml').write_text(text)
        return sample_file.read(str(tmp_path / 's.yaml'))
    return read


def test_all_kinds_of_entries(read, tmp_path):
    cv2.imwrite(str(tmp_path / 'm.png'), np.zeros((2, 2), np.uint8))
    found = read('''
unlabeled: ignored
samples:
- {recording: a.mp4, frame: 3, color: red, rectangle: [10, 20, 30, 40]}
- {recording: a.mp4, color: blue, polygon: [[0, 0], [4.5, 0], [0, 4]]}
- {recording: b.bag, color: none, mask: m.png}
- {color: red, in_view: [1, 2.5]}
- {color: blue, not_in_view: [0, 7]}
''')
    assert found.colors == ('red', 'blue') and found.ignores_unlabeled
    (of_red, red), (_, blue), (of_none, none), *times = found.entries
    assert (of_red, of_none) == ('a.mp4', 'b.bag')
    assert (red.entry, red.color, red.frame) == ('entry 1', 'red', 3)
    assert red.outline == ((10, 20), (39, 20), (39, 59), (10, 59))
    assert (blue.frame, blue.outline) == (0, ((0, 0), (4.5, 0), (0, 4)))
    assert none.mask == (tmp_path / 'm.png').read_bytes()
    assert [(name, each[1:]) for name, each in times] == [
        ('', ('red', 1, 2.5, True)), ('', ('blue', 0, 7, False))]
    assert not read('samples: [{color: red, in_view: [0, 1]}]').ignores_unlabeled


def test_recordings_have_to_be_there_and_to_be_one(read):
    found = read('samples: [{recording: a.mp4, color: red, rectangle: [0, 0, 1, 1]},\n'
                 '          {color: red, in_view: [0, 1]}]')
    found.check_recordings(['/x/a.mp4', 'b.mp4'])
    with pytest.raises(SampleError, match='entry 1: there is no recording a.mp4, did you mean '
                                          'aa.mp4; give it as an argument'):
        found.check_recordings(['aa.mp4'])
    with pytest.raises(SampleError, match="entry 1: 2 recordings are meant by 'a.mp4'; set reco"):
        found.check_recordings(['x/a.mp4', 'y/a.mp4'])


@pytest.mark.parametrize('text, color', [
    ('colors: [red, blue]\nsamples: [{color: red, in_view: [0, 1]}]', 'blue'),
    ('samples: [{color: red, not_in_view: [0, 1]}]', 'red')])
def test_a_color_of_which_nothing_says_where_it_is(read, text, color):
    with pytest.raises(SampleError, match='s.yaml: there is no sample of {}; add'.format(color)):
        read(text).check_colors()


def test_refused_files(read, tmp_path):
    expected.check_cases('refused/samples.txt', lambda text: refusal(read, text).replace(
        '{}/'.format(tmp_path), ''))
