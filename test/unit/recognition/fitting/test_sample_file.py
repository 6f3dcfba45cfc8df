"""Files of samples: what is read, and what is refused with its entry."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.fitting import sample_file
from img_recog.recognition.fitting.samples import SampleError


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


@pytest.mark.parametrize('text, words', [
    ('[', 'cannot read the samples in'), ('a: 1', 'expected a list samples:'),
    ('samples: []', 'there is no sample'), ('samples: [], nix', 'cannot read the samples in'),
    ('sample: 1\nsamples: [1]', 'there is no sample; did you mean samples?'),
    ('unlabeled: 3\nsamples: [{}]', 'unlabeled: got 3, allowed is other or ignored'),
    ('colors: red\nsamples: [{}]', "colors: got 'red', allowed is a list"),
    ('samples: [red]', "entry 1: got 'red', expected lines like color: red"),
    ('samples: [{color: red}]', 'entry 1: got none, expected one of rectangle, polygon, mask,'),
    ('samples: [{color: red, mask: a.png, in_view: [0, 1]}]', 'got mask and in_view, expected'),
    ('samples: [{colour: red}]', 'entry 1: there is no colour; did you mean color?'),
    ('samples: [{color: 7, in_view: [0, 1]}]', 'color: got 7, expected the name of a color'),
    ('colors: [red]\nsamples: [{color: green, in_view: [0, 1]}]',
     'entry 1: there is no color green, the colors are red'),
    ('samples: [{color: none, in_view: [0, 1]}]', 'entry 1: in_view needs a color'),
    ('samples: [{color: red, in_view: [2, 1]}]', 'in_view: got [2, 1], expected [start, end]'),
    ('samples: [{color: red, in_view: [.nan, 1]}]', 'in_view: got [nan, 1], expected'),
    ('samples: [{color: red, recording: 3, in_view: [2, 3]}]', 'recording: got 3, expected'),
    ('samples: [{color: red, frame: -1, rectangle: [0, 0, 1, 1]}]', 'frame: got -1, expected'),
    ('samples: [{color: red, frame: 1.5, rectangle: [0, 0, 1, 1]}]', 'frame: got 1.5, expected'),
    ('samples: [{color: red, rectangle: [0, 0, 0, 1]}]', 'rectangle: got [0, 0, 0, 1], expected'),
    ('samples: [{color: red, rectangle: [0, 0, 1]}]', 'rectangle: got [0, 0, 1], expected'),
    ('samples: [{color: red, polygon: [[0, 0], [1, 1]]}]', 'polygon: got [[0, 0], [1, 1]], expe'),
    ('samples: [{color: red, mask: a.jpg}]', "mask: got 'a.jpg', expected the path of a PNG"),
    ('samples: [{color: red, mask: nix.png}]', 'entry 1: cannot read the mask'),
    ('samples: [{color: red, in_view: [0, 4]}, {color: red, not_in_view: [3, 9]}]',
     'entry 1 and entry 2 contradict each other: red is in view and not in view in 1 s, 25% of '
     'entry 1')])
def test_refused_files(read, text, words):
    with pytest.raises(SampleError) as refused:
        read(text)
    assert words in str(refused.value) and 's.yaml' in str(refused.value)
    assert '\n' not in str(refused.value)
