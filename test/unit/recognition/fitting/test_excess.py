"""Shares of pixels that only frames with a color have."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.fitting.histograms import SHAPE, shares
from img_recog.recognition.fitting.volume import Sparse, sparse

GRAY, RED = (120, 124, 121), (40, 30, 190)      # BGR


def noisy(*colors, sigma=0.0, gain=1.0, seed=0):
    """Return the histogram of 10,000 pixels of each color."""
    image = np.repeat(np.array(colors), 10000, axis=0) * gain
    image += np.random.RandomState(seed).normal(0, sigma, image.shape)
    pixels = cv2.cvtColor(image.clip(0, 255).astype(np.uint8)[:, None], cv2.COLOR_BGR2HSV)[:, 0]
    counts = np.zeros(SHAPE, np.int64)
    np.add.at(counts, tuple(pixels.T), 1)
    return sparse(counts)


def share(seen, unseen, uses_brightness=True):
    """Return which share of all pixels is of the color."""
    found, others = shares(seen, unseen, uses_brightness)
    assert found.shape == others.shape == seen.counts.shape
    assert min(found.min(), others.min()) >= 0 and (found + others).max() <= 1
    return (found * seen.counts).sum() / seen.counts.sum()


@pytest.mark.parametrize('sigma', [0, 2, 4, 8, 12])
def test_noise_is_no_color_and_hides_none(sigma):
    unseen = noisy(GRAY, GRAY, sigma=sigma)
    assert share(noisy(GRAY, GRAY, sigma=sigma, seed=1), unseen) < 0.002
    assert share(noisy(GRAY, RED, sigma=sigma, seed=1), unseen) == pytest.approx(0.5, abs=0.03)


def test_a_gray_that_is_moved_by_a_few_levels_is_no_color():
    seen, unseen = noisy((118, 124, 123)), noisy(GRAY)
    assert not set(seen.indices) & set(unseen.indices)      # the hue has changed
    assert share(seen, unseen) == 0


def test_other_light_is_no_color_if_brightness_is_not_used():
    seen, unseen = noisy(GRAY, RED, gain=1.3), noisy(GRAY, GRAY)
    assert share(seen, unseen) == 1
    assert share(seen, unseen, uses_brightness=False) == 0.5


def test_few_mixed_pixels_are_neither():
    seen = noisy(GRAY, RED)
    mixed = noisy((80, 77, 155))
    # none of them is in both
    both = Sparse(*map(np.concatenate, zip(seen, mixed._replace(counts=mixed.counts // 50))))
    found, others = (each[np.isin(both.indices, mixed.indices)]
                     for each in shares(both, noisy(GRAY, GRAY), True))
    assert not found.any() and not others.any()
