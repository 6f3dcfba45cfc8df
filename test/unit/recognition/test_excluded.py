"""How many pixels each bound excludes, compared with plain numpy."""
import cv2
import numpy as np
import pytest

from img_recog.batch import fit_report
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.recognition_settings import with_colors

ARTICLE = with_colors()()
AROUND = with_colors(['red'])(red_hue_min=170, red_hue_max=10)


def lines(image, settings):
    extractor = ColorExtractor(settings)
    return fit_report.lines(extractor, extractor.measure(image), settings)


def one_color(hue, saturation=200, value=200, size=(4, 5)):
    hsv = np.full(size + (3,), (hue, saturation, value), np.uint8)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)


@pytest.mark.parametrize('image, settings, line', [
    (one_color(5), ARTICLE, 'red: 0 px, not above the limit of 1000 px; out of bounds only by '
     'hue: 20 px (most at 5), only by saturation: 0 px, only by value: 0 px'),
    (one_color(5), AROUND, 'red: 20 px, not above the limit of 1000 px; out of bounds only by '
     'hue: 0 px, only by saturation: 0 px, only by value: 0 px'),
    (one_color(170, 60), ARTICLE, 'hue: 0 px, only by saturation: 20 px, only by value: 0 px'),
    (one_color(170, 200, 120), ARTICLE,
     'hue: 0 px, only by saturation: 0 px, only by value: 20 px'),
    (one_color(170, 60, 120), ARTICLE, 'hue: 0 px, only by saturation: 0 px, only by value: 0 px'),
    (one_color(175), with_colors(['red'])(red_area_limit=19), 'red: 20 px, above the limit of 19'),
    (one_color(175), with_colors(['red'])(min_blob_size=21),
     '; in too small groups or outside of its rows and columns: 20 px'),
    (one_color(175), with_colors(['red'])(red_row_max=0.5), 'rows and columns: 10 px'),
    (one_color(5), with_colors(['red'])(roi_width=2), 'only by hue: 8 px (most at 5)'),
    (one_color(5), with_colors(['red'])(roi_x_offset=5), 'only by hue: 0 px, ')])
def test_a_color_in_one_image(image, settings, line):
    assert line in lines(image, settings)[-1]


def test_noise():
    image = np.random.RandomState(0).randint(0, 256, (40, 60, 3)).astype(np.uint8)
    hue, saturation, value = np.moveaxis(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), 2, 0)
    inside = (hue >= 50) & (hue <= 150), saturation >= 100, value >= 100
    counts = [(~inside[each] & inside[each - 1] & inside[each - 2]).sum() for each in range(3)]
    found = lines(image, ARTICLE)[0]
    for name, count in zip(('hue', 'saturation', 'value'), counts):
        assert 'only by {}: {} px'.format(name, count) in found
