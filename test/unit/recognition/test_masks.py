"""Masks equal plain OpenCV, although only a part of the image is converted to HSV."""
import cv2
import numpy as np
import pytest

from img_recog.recognition import areas
from img_recog.recognition.areas import Masks
from img_recog.recognition.candidates import Search
from img_recog.recognition.recognition_settings import with_colors
from img_recog_helpers import plain_opencv

ARTICLE = with_colors()().colors
BLUE, RED = (215, 70, 25), (60, 25, 215)        # bgr8


def colors(**values):
    return with_colors(['any'])(any_hue_min=0, any_hue_max=180, **{
        'any_' + name: value for name, value in values.items()}).colors


@pytest.mark.parametrize('given, is_useful', [
    (ARTICLE, True), (colors(saturation_min=0, value_min=0), False),      # nearly grey
    (colors(saturation_min=3, value_min=0), False), (colors(saturation_min=60, value_min=0), True),
    # no pixel has it
    (colors(saturation_min=255, saturation_max=255, value_min=0, value_max=0), True)])
def test_for_which_colors_the_search_is_of_use(given, is_useful):
    assert Search((48, 64), given).is_useful is is_useful


def assert_equal_to_plain_opencv(masks, image, given):
    masks.compute(image, cv2.COLOR_BGR2HSV)
    expected = [plain_opencv.mask(image, color) for color in given]
    assert masks.areas_px == [cv2.countNonZero(mask) for mask in expected]
    for number, plain in enumerate(expected):
        assert np.array_equal(masks.mask(number), plain)


def grey_room(seed, shape):
    """Return a bgr8 image of noise that is nearly grey."""
    random = np.random.RandomState(seed)
    grey = random.randint(0, 256, shape + (1,))
    return np.clip(grey + random.randint(-3, 4, shape + (3,)), 0, 255).astype(np.uint8)


def test_every_bgr_color():
    masks = Masks((256, 256), ARTICLE)
    image = np.empty((256, 256, 3), np.uint8)
    image[..., 0], image[..., 1] = np.mgrid[:256, :256]
    for red in range(256):
        image[..., 2] = red
        assert_equal_to_plain_opencv(masks, image, ARTICLE)


def set_strip_px(monkeypatch, size_px):
    """Let masks be computed in strips of this size."""
    for name in ('_MIN_STRIP_PX', '_MAX_STRIP_PX'):
        monkeypatch.setattr(areas, name, size_px)


@pytest.mark.parametrize('given', [
    ARTICLE, ARTICLE[:1], ARTICLE[1:], colors(saturation_min=1), colors(saturation_min=255),
    colors(saturation_min=0), colors(value_min=250), colors(saturation_min=60, value_min=3),
    colors(saturation_min=30, saturation_max=40, value_min=0, value_max=90),
    colors(saturation_min=200, saturation_max=200, value_min=51, value_max=52)])
def test_each_pixel_is_found_alone(monkeypatch, given):
    """The image has, for each value, the pixels of a color that are nearest to grey."""
    value, smallest = np.mgrid[:256, :256]
    pairs = np.stack([value, smallest], axis=-1)[smallest <= value]
    nearest = []
    for middle in (pairs[:, 0], pairs[:, 1], pairs.mean(axis=1)):
        for order in ([0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]):
            pixels = np.column_stack([pairs, middle])[:, order].astype(np.uint8)
            inside = np.any([plain_opencv.mask(pixels[:, np.newaxis], color)
                             for color in given], axis=0).ravel()
            # pairs are sorted: the last one of a value is the nearest to grey
            _, last = np.unique(pairs[inside][::-1, 0], return_index=True)
            nearest.append(pixels[inside][::-1][last])
    image = np.concatenate(nearest)[:, np.newaxis]
    set_strip_px(monkeypatch, 1)
    masks = Masks(image.shape[:2], given)
    assert_equal_to_plain_opencv(masks, image, given)
    assert masks.areas_px[0] > 0


def test_a_range_without_any_pixel():
    given = colors(saturation_min=200, saturation_max=200, value_min=7, value_max=7)
    image = np.random.RandomState(0).randint(0, 9, (48, 64, 3), np.uint8)
    assert_equal_to_plain_opencv(Masks((48, 64), given), image, given)


@pytest.mark.parametrize('shape', [(480, 640), (1080, 1920), (47, 31), (3, 200000), (1, 131073)])
def test_colors_that_move_through_a_grey_room(shape):
    masks = Masks(shape, ARTICLE)
    height, width = shape
    places = [(0, 0, 1, 1), (height - 1, width - 1, 1, 1), (0, width // 2, height, 1),
              (height // 2, 0, 1, width), (height // 3, width // 3, height // 3, width // 3),
              (0, 0, 0, 0), (height // 2, width // 2, 2, 2), (0, 0, height, width),
              (height // 2, width // 2, 2, 2), (0, 0, 0, 0)]
    for number, (top, left, rows, columns) in enumerate(places):
        image = grey_room(number, shape)
        image[top:top + rows, left:left + columns] = BLUE if number % 2 else RED
        assert_equal_to_plain_opencv(masks, image, ARTICLE)


def test_an_image_full_of_color_followed_by_empty_ones():
    masks = Masks((48, 64), ARTICLE)
    for _ in range(3):
        for number in range(20):
            assert_equal_to_plain_opencv(
                masks, np.random.RandomState(number).randint(0, 256, (48, 64, 3), np.uint8),
                ARTICLE)
        for _ in range(20):
            assert_equal_to_plain_opencv(masks, np.full((48, 64, 3), 128, np.uint8), ARTICLE)


def test_only_pixels_that_can_have_a_color_are_converted(monkeypatch):
    converted, cvt_color = [], cv2.cvtColor

    def recorded(image, *arguments, **names):
        converted.append(image.shape[:2])
        return cvt_color(image, *arguments, **names)
    masks = Masks((480, 640), ARTICLE)
    image = np.full((480, 640, 3), 128, np.uint8)
    image[100:110, 300:330] = BLUE
    monkeypatch.setattr(cv2, 'cvtColor', recorded)
    masks.compute(image, cv2.COLOR_BGR2HSV)
    assert sum(height * width for height, width in converted) == 10 * 40    # in groups of 8
    assert masks.areas_px == [300, 0]
    converted.clear()
    image[:] = BLUE
    for _ in range(3):
        masks.compute(image, cv2.COLOR_BGR2HSV)
    assert sum(height * width for height, width in converted) == 3 * 480 * 640
    image[:, 30:] = 128
    for _ in range(100):
        converted.clear()
        masks.compute(image, cv2.COLOR_BGR2HSV)
        assert masks.areas_px == [480 * 30, 0]
        if sum(height * width for height, width in converted) == 480 * 32:
            break
    else:
        pytest.fail('the search is never repeated')


@pytest.mark.parametrize('conversion', [cv2.COLOR_BGR2HSV, cv2.COLOR_RGB2HSV])
@pytest.mark.parametrize('channels', [3, 4])
def test_the_groups_of_a_color(conversion, channels):
    masks, bgr = Masks((48, 64), ARTICLE), np.full((48, 64, 3), 128, np.uint8)
    bgr[10, 20], bgr[11, 0:9], bgr[40, 63] = BLUE, BLUE, RED
    image = bgr if conversion == cv2.COLOR_BGR2HSV else bgr[..., ::-1]
    masks.compute(np.dstack([image, bgr[..., :channels - 3]]), conversion)
    for number, wanted in enumerate(([10 * 8 + 2, 11 * 8, 11 * 8 + 1], [40 * 8 + 7])):
        indices, pixels = masks.groups_inside(number)
        assert indices.tolist() == wanted
        masked = np.zeros((48 * 8, 8, 3), np.uint8)
        masked[indices] = pixels.view(np.uint8).reshape(-1, 8, 3)
        assert np.array_equal(masked.reshape(48, 64, 3),
                              bgr & np.dstack([masks.mask(number)] * 3))


@pytest.mark.parametrize('rows, are_few', [(51, True), (52, False)])
def test_the_groups_of_a_color_are_known_if_they_are_few(rows, are_few):
    masks, image = Masks((512, 640), ARTICLE), np.full((512, 640, 3), 128, np.uint8)
    image[:300] = 0, 255, 255       # as saturated as a color, and more than are tested at once
    image[280:280 + rows] = BLUE
    masks.compute(image, cv2.COLOR_BGR2HSV)
    assert masks.areas_px == [rows * 640, 0]
    groups = masks.groups_inside(0)
    if are_few:
        assert list(groups.indices) == list(range(280 * 80, (280 + rows) * 80))
        assert (groups.bgr.view(np.uint8).reshape(-1, 3) == BLUE).all()
    else:
        assert groups is None
    assert len(masks.groups_inside(1).indices) == 0


def test_no_groups_of_an_image_that_was_converted_as_a_whole():
    everything, = colors(saturation_min=0, value_min=0)
    masks = Masks((48, 64), [everything, *colors(saturation_min=0, value_min=3)])
    masks.compute(np.zeros((48, 64, 3), np.uint8), cv2.COLOR_BGR2HSV)
    assert masks.groups_inside(0) is None and masks.groups_inside(1) is None
    assert masks.areas_px == [48 * 64, 0]
