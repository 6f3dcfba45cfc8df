"""Bounds that are offered for marked samples."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.fitting import marked, offers
from img_recog.recognition.fitting.marked import Marked


@pytest.fixture(scope='module')
def samples():
    """A red square, and a part of a wall that is called blue and has the color of the rest."""
    image = np.full((90, 120, 3), (206, 200, 190), np.uint8)
    image[20:60, 20:60] = (40, 30, 190)
    image = np.clip(image + np.random.RandomState(1).normal(0, 5, image.shape), 0, 255)
    now, name = marked.with_picture(Marked(), image.astype(np.uint8))
    now = marked.with_click(now, name, 40 / 120, 40 / 90, 'red')
    return marked.with_rectangle(now, name, 0.7, 0.1, 0.2, 0.2, 'blue')


def test_bounds_with_shares_or_what_overlaps(samples):
    found = offers.offers(samples)
    assert list(found) == ['red', 'blue']
    assert found['red'].marked_inside > 0.97 and found['red'].others_inside < 0.01
    hue = int(cv2.cvtColor(np.uint8([[(40, 30, 190)]]), cv2.COLOR_BGR2HSV)[0, 0, 0])
    low, high = found['red'].box.hue
    assert low <= hue <= high or low > high
    assert found['blue'][:3] == (None, 0.0, 0.0)
    assert 'no bounds separate blue' in found['blue'].problem
    assert 'of its pixels have a color that others have too, most at hue' in found['blue'].problem


def test_without_others_all_that_is_marked_is_inside(samples):
    blue = offers.offers(samples._replace(rest_is_none=False))['blue']
    assert blue.marked_inside > 0.97
