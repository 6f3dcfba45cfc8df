"""Bounds from a click into an image: the node then recognizes what was clicked."""
import cv2
import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.proposal import propose_bounds
from img_recog.recognition.settings import with_colors


def scene(bgr, noise=6):
    """Return a gray image with a square of a color in its middle, and noise."""
    image = np.full((120, 160, 3), 128, np.uint8)
    image[40:80, 60:100] = bgr
    shift = np.random.RandomState(1).randint(-noise, noise + 1, image.shape)
    return np.clip(image.astype(int) + shift, 0, 255).astype(np.uint8)


def area_px(image, bounds):
    settings = with_colors(['this'])(**{'this_' + part: value for part, value in bounds.items()})
    return ColorExtractor(settings).measure(image, 'bgr8')[0]


@pytest.mark.parametrize('bgr', [(200, 60, 30), (30, 180, 40), (40, 40, 210), (30, 60, 220),
                                 (60, 30, 220), (20, 200, 220), (90, 60, 60)])
def test_the_square_that_was_clicked_is_recognized_and_nothing_else(bgr):
    image = scene(bgr)
    bounds = propose_bounds(image, 0.5, 0.5)
    assert 1550 <= area_px(image, bounds) <= 1600
    assert all(0 <= bounds[part] <= 180 for part in ('hue_min', 'hue_max'))
    assert all(0 <= bounds[part] <= 255 for part in bounds)
    assert all(isinstance(value, int) for value in bounds.values())


@pytest.mark.parametrize('bgr', [(128, 128, 128), (206, 200, 190), (20, 0, 0), (255, 255, 255)])
def test_what_has_no_clear_color_is_refused(bgr):
    with pytest.raises(UserError, match='too gray or too dark: saturation .*clear color'):
        propose_bounds(scene(bgr, noise=0), 0.5, 0.5)


def test_the_hue_of_red_wraps_around():
    bounds = propose_bounds(scene((30, 30, 220), noise=0), 0.5, 0.5)
    assert bounds['hue_min'] > bounds['hue_max']


@pytest.mark.parametrize('x, y', [(0.0, 0.0), (1.0, 1.0), (-5.0, 7.0)])
def test_a_click_at_the_edge(x, y):
    image = np.zeros((5, 7, 3), np.uint8)
    image[:] = (200, 60, 30)
    hue = int(cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[0, 0, 0])
    bounds = propose_bounds(image, x, y)
    assert bounds['hue_min'] <= hue <= bounds['hue_max']
