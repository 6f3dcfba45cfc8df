"""Compares color areas with plain OpenCV and numpy, for the article's ranges and others."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.areas import ENCODINGS, ColorExtractor
from img_recog.recognition.recognition_settings import with_colors
from img_recog_helpers import plain_opencv
from img_recog_helpers.extraction import extractor, random_image


def in_range(image, color):
    """Return, by numpy alone, which pixels of a bgr8 image are inside the range of a color."""
    hue, saturation, value = np.moveaxis(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), 2, 0)
    low, high = color.hue
    inside = ((hue >= low) & (hue <= high)) if low <= high else ((hue >= low) | (hue <= high))
    for plane, (low, high) in ((saturation, color.saturation), (value, color.value)):
        inside &= (plane >= low) & (plane <= high)
    return inside


def assert_equal_to_plain_opencv(image, settings=with_colors()()):
    found = ColorExtractor(settings)
    areas_px = found.measure(image)
    assert len(areas_px) == len(settings.colors)
    assert np.array_equal(found.bgr(), image)
    for number, color in enumerate(settings.colors):
        inside = in_range(image, color)
        if color.hue[0] <= color.hue[1]:
            mask = plain_opencv.mask(image, color)
            assert np.array_equal(mask == 255, inside)
            assert areas_px[number] == cv2.countNonZero(mask)
            assert np.array_equal(found.masked(number), cv2.bitwise_and(image, image, mask=mask))
        assert areas_px[number] == inside.sum()
        assert np.array_equal(found.mask(number), np.where(inside, 255, 0))
        masked = found.masked(number)
        assert masked.dtype == np.uint8 and masked.shape == image.shape
        assert np.array_equal(masked, np.where(inside[..., np.newaxis], image, 0))


@pytest.mark.parametrize('seed, shape', [
    *((seed, (*size, 3)) for seed in range(5) for size in ((480, 640), (3, 5), (1, 1), (3, 1))),
    *((1, (*size, 3)) for size in ((1080, 1920), (523, 1003), (3, 600000)))])
def test_random_frames_equal_plain_opencv(seed, shape):
    assert_equal_to_plain_opencv(random_image(seed, shape))


def test_random_frames_have_both_colors():
    assert all(area_px > 1000 for area_px in extractor().measure(random_image(0, (480, 640, 3))))


@pytest.mark.parametrize('seed', range(40))
def test_any_ranges_equal_plain_opencv(seed):
    random = np.random.RandomState(seed)
    values = {}
    for name in ('blue', 'red'):
        values[name + '_hue_min'], values[name + '_hue_max'] = map(int, random.randint(0, 181, 2))
        for part in ('saturation', 'value'):
            low, high = sorted(map(int, random.choice([0, 1, 60, 100, 254, 255], 2)))
            values['{}_{}_min'.format(name, part)] = low
            values['{}_{}_max'.format(name, part)] = high
    assert_equal_to_plain_opencv(random_image(seed, (48, 64, 3)), with_colors()(**values))


@pytest.mark.parametrize('low', [0, 1, 90, 178, 179, 180])
@pytest.mark.parametrize('high', [0, 1, 90, 178, 179, 180])
def test_hues_wrap(low, high):
    hues = cv2.cvtColor(np.array([[(hue, 200, 200) for hue in range(180)]], np.uint8),
                        cv2.COLOR_HSV2BGR)
    settings = with_colors(['any'])(any_hue_min=low, any_hue_max=high, any_saturation_min=0,
                                    any_value_min=0)
    assert_equal_to_plain_opencv(hues, settings)


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_every_encoding_gives_the_same_result(encoding):
    image = random_image(4)
    given = np.dstack([image, random_image(5)[..., 0]]) if 'a' in encoding else image
    if encoding.startswith('rgb'):
        given = np.ascontiguousarray(given[..., [2, 1, 0, 3][:given.shape[2]]])
    found, plain = extractor(), extractor()
    assert found.measure(given, encoding) == plain.measure(image)
    assert np.array_equal(found.bgr(), image)
    for number in (0, 1):
        assert np.array_equal(found.masked(number), plain.masked(number))


def test_rows_that_are_not_contiguous_and_read_only_memory():
    image = random_image(6, (48, 80, 3))
    image.setflags(write=False)
    found, plain = extractor(), extractor()
    assert found.measure(image[:, 3:67]) == plain.measure(image[:, 3:67].copy())
    for number in (0, 1):
        assert np.array_equal(found.masked(number), plain.masked(number))


def test_input_is_unchanged_and_shares_no_memory_with_results():
    image = random_image(7)
    before, found = image.copy(), extractor()
    found.measure(image)
    blue, red = found.masked(0), found.masked(1)
    assert np.array_equal(image, before)
    assert not np.shares_memory(blue, image) and not np.shares_memory(blue, red)


@pytest.mark.parametrize('encoding', ENCODINGS)
@pytest.mark.parametrize('shape', [(0, 5), (5, 0), (0, 0)])
def test_an_image_without_pixels(shape, encoding):
    found = extractor()
    found.measure(random_image(0))
    assert found.measure(np.zeros(shape + (4 if 'a' in encoding else 3,), np.uint8), encoding) == [
        0, 0]
    assert found.bgr().shape[:2] == found.mask(0).shape == found.masked(0).shape[:2] == shape
    assert found.centroid(0) is None


def test_results_do_not_depend_on_earlier_images():
    found = extractor()
    for seed, shape in enumerate([(48, 64, 3), (20, 64, 3), (600, 1000, 3), (48, 64, 3), (1, 1, 3),
                                  (48, 30, 3)]):
        image, plain = random_image(seed, shape), extractor()
        assert found.measure(image) == plain.measure(image)
        for number in (0, 1):
            assert np.array_equal(found.masked(number), plain.masked(number))
            assert np.array_equal(found.mask(number), plain.mask(number))
    black = np.zeros((48, 64, 3), np.uint8)
    assert found.measure(black) == [0, 0] and not found.masked(0).any()


def scene(seed, encoding, shape):
    """Return an image with a grey background and colored rectangles, in an encoding and bgr8."""
    random = np.random.RandomState(seed)
    image = np.full(shape + (3,), 120, np.uint8)
    for color in ((215, 70, 25), (60, 25, 215), (25, 200, 60)):
        top, left = random.randint(0, shape[0]), random.randint(0, shape[1])
        image[top:top + random.randint(0, 12), left:left + random.randint(0, 30)] = color
    return {'bgr8': image, 'rgb8': np.ascontiguousarray(image[..., ::-1]),
            'bgra8': np.dstack([image, image[..., 0]]),
            'rgba8': np.dstack([image[..., ::-1], image[..., 0]])}[encoding], image


@pytest.mark.parametrize('values', [
    {}, {'roi_x_offset': 8, 'roi_width': 40}, {'blue_column_min': 0.25}, {'min_blob_size': 9}])
@pytest.mark.parametrize('shape', [(48, 64), (7, 9)])
@pytest.mark.parametrize('encoding', ENCODINGS)
def test_images_drawn_one_over_the_other(encoding, shape, values):
    found = extractor(**values)
    plain = extractor(**values)
    drawn, notes = np.full((2,) + shape + (3,), 77, np.uint8), [None, None]
    for seed in range(60):
        image, bgr = scene(seed, encoding, shape)
        if seed % 20 == 13:
            image = bgr = random_image(seed, shape + (3,))      # is processed as a whole
        kind = 'bgr8' if image is bgr else encoding
        found.measure(image, kind)
        plain.measure(bgr)
        for number in range(2):
            note = notes[number] if seed % 7 else None      # other memory
            notes[number] = found.draw_masked(number, drawn[number], note)
            assert np.array_equal(drawn[number],
                                  cv2.bitwise_and(bgr, bgr, mask=plain.mask(number)))
            assert np.array_equal(drawn[number], found.masked(number))


def test_other_settings_apply_from_the_next_image_on():
    image, found = random_image(9), extractor()
    before = found.measure(image)
    found.configure(with_colors()(blue_hue_min=100))
    assert found.masked(0).any()
    after = found.measure(image)
    assert after[0] < before[0] and after[1] == before[1]
    found.configure(with_colors(['red'])())
    assert found.measure(image) == [before[1]]


def test_a_region_of_interest():
    image = random_image(10)
    found, part = extractor(roi_x_offset=10, roi_y_offset=5, roi_width=20, roi_height=30), \
        extractor()
    assert found.measure(image) == part.measure(image[5:35, 10:30])
    for number in (0, 1):
        masked = found.masked(number)
        assert masked.shape == image.shape
        assert np.array_equal(masked[5:35, 10:30], part.masked(number))
        masked[5:35, 10:30] = 0
        assert not masked.any()
        x, y = part.centroid(number)
        assert found.centroid(number) == (x + 10, y + 5)


@pytest.mark.parametrize('roi, size', [
    ({'roi_x_offset': 60}, 4 * 48), ({'roi_y_offset': 40, 'roi_height': 1000}, 8 * 64),
    ({'roi_x_offset': 64}, 0), ({'roi_x_offset': 1000, 'roi_y_offset': 1000}, 0)])
def test_a_region_partly_or_completely_outside_of_the_image(roi, size):
    found = extractor(**roi)
    assert found.measure(np.full((48, 64, 3), (215, 70, 25), np.uint8)) == [size, 0]
    assert (found.masked(0).any(axis=2).sum(), found.masked(1).any()) == (size, False)
    assert (found.mask(0) == 255).sum() == size


def test_small_blobs_do_not_count():
    image = np.zeros((48, 64, 3), np.uint8)
    # the last pixel touches a blob only at its corner
    image[2:5, 2:5] = image[20:30, 20:40] = image[30, 40] = (215, 70, 25)
    for blob_px, area_px in ((0, 210), (1, 210), (9, 210), (10, 201), (201, 201), (202, 0)):
        found = extractor(min_blob_size=blob_px)
        assert found.measure(image) == [area_px, 0]
        assert (found.mask(0) == 255).sum() == area_px
        assert found.masked(0).any(axis=2).sum() == area_px


@pytest.mark.parametrize('blob_px, area_px', [(3072, 3072), (3073, 0)])
def test_a_blob_of_all_pixels(blob_px, area_px):
    found = extractor(min_blob_size=blob_px)
    assert found.measure(np.full((48, 64, 3), (215, 70, 25), np.uint8)) == [area_px, 0]
    assert (found.mask(0) == 255).sum() == area_px


def test_centroids_are_the_mean_of_the_pixels():
    image, found = random_image(11), extractor()
    found.measure(image)
    for number in (0, 1):
        rows, columns = np.nonzero(found.mask(number))
        assert found.centroid(number) == pytest.approx((columns.mean(), rows.mean()), abs=1e-9)


@pytest.mark.parametrize('part, shares, expected', [
    ('column', (0.0, 1.0), 40), ('column', (0.0, 0.5), 20), ('column', (0.5, 1.0), 20),
    ('column', (0.25, 0.5), 10), ('column', (0.5, 0.5), 0), ('column', (0.26, 0.49), 10),
    ('row', (0.0, 1.0), 40), ('row', (0.0, 0.5), 20), ('row', (0.8, 1.0), 8),
    ('row', (0.24, 0.51), 10), ('row', (1.0, 1.0), 0)])
def test_pixels_outside_of_the_columns_and_rows_of_a_color_do_not_count(part, shares, expected):
    axis = ('row', 'column').index(part)
    image = np.full(((20, 2), (2, 20))[axis] + (3,), (200, 60, 20), np.uint8)       # blue
    extractor = ColorExtractor(with_colors(['part', 'all'])(
        part_hue_min=100, part_hue_max=130, all_hue_min=100, all_hue_max=130,
        **dict(zip(('part_{}_min'.format(part), 'part_{}_max'.format(part)), shares))))
    for _ in range(2):      # the buffers are reused
        assert extractor.measure(image) == [expected, 40]
    kept = np.flatnonzero(extractor.mask(0).all(axis=1 - axis))
    assert len(kept) == expected // 2
    if expected:
        assert (kept[0], kept[-1]) == (round(shares[0] * 20), round(shares[1] * 20) - 1)
        assert extractor.centroid(0)[1 - axis] == pytest.approx(kept.mean())
        assert extractor.centroid(0)[axis] == 0.5
    assert np.count_nonzero(extractor.masked(0).any(axis=2)) == expected


@pytest.mark.parametrize('values, kept', [
    ({'roi_height': 1}, [[0, 8], [0, 9]]),
    ({'part_row_min': 0.5, 'roi_y_offset': 4, 'roi_height': 2}, [[5, 8], [5, 9]])])
def test_columns_and_rows_are_those_of_the_whole_image_with_a_region_of_interest(values, kept):
    extractor = ColorExtractor(with_colors(['part'])(
        part_hue_min=100, part_hue_max=130, part_column_max=0.5, roi_x_offset=8, roi_width=6,
        **values))
    assert extractor.measure(np.full((10, 20, 3), (200, 60, 20), np.uint8)) == [2]
    assert np.argwhere(extractor.mask(0)).tolist() == kept
