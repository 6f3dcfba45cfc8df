"""Colour areas against plain OpenCV and numpy, with the article's ranges."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.areas import extract
from img_recog.recognition.settings import BLUE, RED, ColorRange

COLORS = [BLUE.color, RED.color]

# bgr8 pixels at both sides of each bound, with the HSV that OpenCV gives them
BOUNDS = [
    # bgr, hsv, in blue, in red
    ((0, 200, 64), (50, 255, 200), True, False),
    ((0, 200, 70), (49, 255, 200), False, False),
    ((204, 150, 124), (110, 100, 204), True, False),
    ((201, 148, 123), (110, 99, 201), False, False),
    ((100, 32, 0), (110, 255, 100), True, False),
    ((99, 32, 0), (110, 255, 99), False, False),
    ((251, 0, 255), (150, 255, 255), True, True),
    ((200, 0, 191), (149, 255, 200), True, False),
    ((191, 0, 200), (151, 255, 200), False, True),
    ((4, 0, 200), (179, 255, 200), False, True),
    ((0, 0, 200), (0, 255, 200), False, False),
    ((148, 122, 201), (170, 100, 201), False, True),
    ((147, 122, 200), (170, 99, 200), False, False),
    ((48, 0, 150), (170, 255, 150), False, True),
    ((48, 0, 149), (170, 255, 149), False, False),
]


def assert_equal_to_plain_opencv(image):
    hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
    for color, area in zip(COLORS, extract(image, COLORS)):
        mask = cv2.inRange(hsv, color.lower, color.upper)
        by_numpy = ((hsv >= color.lower) & (hsv <= color.upper)).all(axis=2)
        assert np.array_equal(mask == 255, by_numpy)
        assert area.name == color.name
        assert area.area_px == cv2.countNonZero(mask) == by_numpy.sum()
        assert area.image.dtype == np.uint8 and area.image.shape == image.shape
        assert np.array_equal(area.image, cv2.bitwise_and(image, image, mask=mask))
        assert np.array_equal(area.image, np.where(by_numpy[..., np.newaxis], image, 0))


@pytest.mark.parametrize('seed', range(5))
@pytest.mark.parametrize('shape', [(480, 640, 3), (3, 5, 3), (1, 1, 3), (3, 1, 3)])
def test_random_frames_equal_plain_opencv(seed, shape):
    assert_equal_to_plain_opencv(
        np.random.RandomState(seed).randint(0, 256, shape).astype(np.uint8))


def test_random_frames_have_both_colours():
    image = np.random.RandomState(0).randint(0, 256, (480, 640, 3)).astype(np.uint8)
    assert all(area.area_px > 1000 for area in extract(image, COLORS))


def test_frame_whose_pixels_belong_to_both_colours():
    image = np.zeros((40, 60, 3), np.uint8)
    image[:, :20], image[:, 20:30] = (255, 0, 255), (255, 40, 0)
    assert_equal_to_plain_opencv(image)
    blue, red = extract(image, COLORS)
    assert (blue.area_px, red.area_px) == (40 * 30, 40 * 20)
    assert np.array_equal(blue.image[:, :20], red.image[:, :20])
    assert np.array_equal(blue.image, image)
    assert not red.image[:, 20:].any()


@pytest.mark.parametrize('bgr, hsv, in_blue, in_red', BOUNDS)
def test_bounds_of_the_articles_ranges(bgr, hsv, in_blue, in_red):
    image = np.full((1, 1, 3), bgr, np.uint8)
    assert tuple(cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[0, 0]) == hsv
    assert [area.area_px for area in extract(image, COLORS)] == [in_blue, in_red]
    for area, inside in zip(extract(image, COLORS), (in_blue, in_red)):
        assert tuple(area.image[0, 0]) == (bgr if inside else (0, 0, 0))


@pytest.mark.parametrize('channel', [0, 1, 2])
def test_bounds_are_included_at_both_ends_of_each_channel(channel):
    image, hsv = np.full((2, 3, 3), (191, 60, 200), np.uint8), np.array([152, 178, 200])
    assert np.array_equal(cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[0, 0], hsv)

    def area_px(lower, upper):
        return extract(image, [ColorRange('c', tuple(lower), tuple(upper))])[0].area_px

    step = np.eye(3, dtype=int)[channel]
    assert area_px(hsv, hsv) == 6
    assert area_px(hsv + step, [255, 255, 255]) == 0
    assert area_px([0, 0, 0], hsv - step) == 0
    assert area_px(hsv, hsv + step) == 6
    assert area_px(hsv - step, hsv) == 6


@pytest.mark.parametrize('value', [0, 128, 255])
def test_black_grey_and_white_have_no_colour(value):
    for area in extract(np.full((48, 64, 3), value, np.uint8), COLORS):
        assert area.area_px == 0
        assert not area.image.any()


def test_whole_frame_of_a_colour():
    image = np.full((48, 64, 3), (215, 70, 25), np.uint8)
    blue, red = extract(image, COLORS)
    assert (blue.area_px, red.area_px) == (48 * 64, 0)
    assert np.array_equal(blue.image, image)


def test_input_is_left_alone_and_results_share_no_memory():
    image = np.random.RandomState(7).randint(0, 256, (48, 64, 3)).astype(np.uint8)
    before = image.copy()
    blue, red = extract(image, COLORS)
    assert np.array_equal(image, before)
    assert not np.shares_memory(blue.image, image)
    assert not np.shares_memory(blue.image, red.image)


def test_areas_stand_in_the_order_of_the_colours():
    image = np.zeros((4, 4, 3), np.uint8)
    assert [area.name for area in extract(image, COLORS)] == ['blue', 'red']
    assert [area.name for area in extract(image, COLORS[::-1])] == ['red', 'blue']
    assert extract(image, []) == []
