"""Noise of a camera's pixels."""
import numpy as np
import pytest

from img_recog.rendering.light import PixelNoise


@pytest.fixture(scope='module')
def noise():
    return PixelNoise(0.02)


def noisy(noise, number, value=100, shape=(480, 640, 3)):
    image = np.full(shape, value, np.uint8)
    noise.add(image, number)
    return image


def test_deviation_and_mean(noise):
    image = noisy(noise, 5).astype(float)
    assert image.mean() == pytest.approx(100, abs=0.05)
    assert image.std() == pytest.approx(0.02 * 255, rel=0.03)
    # Gazebo's grey of 128 becomes 154, without a deviation
    assert noisy(PixelNoise(0.0, 0.1), 5, value=128).mean() == pytest.approx(154, abs=0.6)
    small = [noisy(noise, number, shape=(4, 4, 3)) for number in range(20)]
    assert np.std(small, axis=0).min() > 2      # of each color


def test_equal_numbers_give_equal_noise_and_others_do_not(noise):
    assert np.array_equal(noisy(noise, 1), noisy(noise, 1))
    assert (noisy(noise, 1) != noisy(noise, 2)).mean() > 0.8
    assert np.array_equal(noisy(PixelNoise(0.02), 7), noisy(noise, 7))


def test_colors_of_a_pixel_have_one_noise_as_in_gazebo_and_neighbors_are_independent(noise):
    image = noisy(noise, 3).astype(float) - 100
    assert np.array_equal(image[..., 0], image[..., 1])
    assert np.array_equal(image[..., 0], image[..., 2])
    for first, second in ((image[:, 1:], image[:, :-1]), (image[1:], image[:-1])):
        assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.01


@pytest.mark.parametrize('value', [0, 255])
def test_colors_stay_in_their_range(noise, value):
    image = noisy(noise, 3, value)
    assert abs(float(np.median(image)) - value) <= 1
    assert abs(image.astype(int) - value).max() < 40


def test_an_image_that_is_larger_than_the_table(noise):
    image = noisy(noise, 1, shape=(1500, 1500, 3))
    assert image.std() == pytest.approx(0.02 * 255, rel=0.03)
