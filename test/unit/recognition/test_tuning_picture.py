"""Compares the statistics of the tuning picture with plain numpy, and checks its pixels."""
import colorsys
import io
import os

import cv2
import numpy as np
import pytest

from img_recog.recognition import tuning_picture
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.settings import with_colors
from img_recog.recognition.tuning_statistics import frame_statistics, spans, within
from img_recog_testing.figures import assert_unchanged, of_matplotlib

ARTICLE = with_colors()()
FIVE = with_colors(['blue', 'red', 'green', 'yellow', 'all_of_the_red'])(
    green_hue_min=40, green_hue_max=80, yellow_hue_min=20, yellow_hue_max=35, yellow_area_limit=0,
    all_of_the_red_hue_min=170, all_of_the_red_hue_max=10)


def measured(image, settings):
    extractor = ColorExtractor(settings)
    return frame_statistics(extractor, extractor.measure(image), settings)


def noise(seed=0, shape=(40, 60, 3)):
    return np.random.RandomState(seed).randint(0, 256, shape).astype(np.uint8)


def one_color(hue, saturation=200, value=200, size=(4, 5)):
    hsv = np.full(size + (3,), (hue, saturation, value), np.uint8)
    return cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)


@pytest.mark.parametrize('settings', [ARTICLE, FIVE], ids=['article', 'five'])
def test_statistics_equal_plain_numpy(settings):
    image = noise()
    statistics = measured(image, settings)
    hues, saturations, values = np.moveaxis(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), 2, 0)
    seen = np.zeros(hues.shape, bool)
    for color, got in zip(settings.colors, statistics.colors):
        allowed = set()
        for low, high in spans(color.hue):
            allowed |= set(range(low, high + 1))
        hue = np.isin(hues, sorted(allowed))
        saturation = (saturations >= color.saturation[0]) & (saturations <= color.saturation[1])
        value = (values >= color.value[0]) & (values <= color.value[1])
        seen |= saturation & value
        assert got.area_px == got.in_bounds_px == (hue & saturation & value).sum()
        assert got.missed_px == ((~hue & saturation & value).sum(),
                                 (hue & ~saturation & value).sum(),
                                 (hue & saturation & ~value).sum())
        for counts, plane, other in ((got.saturation, saturations, value),
                                     (got.value, values, saturation)):
            edges = np.arange(257)
            assert (counts.all_px == np.histogram(plane[hue], edges)[0]).all()
            assert (counts.passing_px == np.histogram(plane[hue & other], edges)[0]).all()
    assert (statistics.hue.all_px == np.histogram(hues, np.arange(182))[0]).all()
    assert (statistics.hue.passing_px == np.histogram(hues[seen], np.arange(182))[0]).all()


def test_colored_bars_in_bounds_are_the_area():
    image = noise(1)
    for color, got in zip(FIVE.colors, measured(image, FIVE).colors):
        for counts, (low, high) in ((got.saturation, color.saturation), (got.value, color.value)):
            assert counts.passing_px[low:high + 1].sum() == got.area_px


def test_red_at_the_other_end_of_the_hues_is_reported():
    red = measured(one_color(5), ARTICLE).colors[1]
    assert (red.area_px, red.missed_px, red.missed_hue) == (0, (20, 0, 0), 5)
    assert 'only by hue: 20 px (most at 5)' in tuning_picture.reason(red)
    around = measured(one_color(5), FIVE).colors[4]
    assert (around.area_px, around.missed_px, around.missed_hue) == (20, (0, 0, 0), None)


@pytest.mark.parametrize('saturation, value, text', [
    (60, 200, 'only by hue: 0 px, only by saturation: 20 px, only by value: 0 px'),
    (200, 120, 'only by hue: 0 px, only by saturation: 0 px, only by value: 20 px'),
    (60, 120, 'only by hue: 0 px, only by saturation: 0 px, only by value: 0 px')])
def test_dull_or_dark_pixels_are_reported(saturation, value, text):
    red = measured(one_color(170, saturation, value), ARTICLE).colors[1]
    assert text in tuning_picture.reason(red)


def test_small_blobs_are_reported():
    settings = with_colors()(min_blob_size=21)
    blue = measured(one_color(110), settings).colors[0]
    assert (blue.area_px, blue.in_bounds_px) == (0, 20)
    assert tuning_picture.reason(blue).endswith('in too small blobs: 20 px')


@pytest.mark.parametrize('roi, expected_px', [
    ({}, 2400), ({'roi_x_offset': 50, 'roi_y_offset': 30}, 100),
    ({'roi_width': 7, 'roi_height': 3}, 21), ({'roi_x_offset': 55, 'roi_width': 100}, 200),
    ({'roi_x_offset': 60}, 0), ({'roi_y_offset': 1000, 'roi_height': 1}, 0)])
def test_pixels_outside_of_the_region_are_not_counted(roi, expected_px):
    settings = with_colors()(**roi)
    image = one_color(110, size=(40, 60))
    statistics = measured(image, settings)
    assert statistics.hue.all_px.sum() == statistics.colors[0].area_px == expected_px
    assert image[settings.region(image.shape[:2])].size == 3 * expected_px
    figure, areas_px = tuning_picture.draw(image, settings)
    assert areas_px == [expected_px, 0]
    assert rendered(figure).std() > 0


def test_hues_through_zero():
    assert spans((170, 10)) == [(170, 180), (0, 10)]
    assert spans((50, 150)) == [(50, 150)]
    hues = np.arange(181, dtype=np.uint8)
    assert list(hues[within(hues, (178, 1))]) == [0, 1, 178, 179, 180]


@pytest.mark.parametrize('limit, side', [(19, 'above'), (20, 'not above'), (21, 'below')])
def test_the_verdict_has_area_and_limit(limit, side):
    settings = with_colors(['blue'])(blue_area_limit=limit)
    assert tuning_picture.verdict(settings.colors[0], 20) == (
        'blue: 20 px, {} the limit of {} px'.format(side, limit))
    assert tuning_picture.bounds(settings.colors[0]) == (
        'hue 50-150, saturation 100-255, value 100-255')


def rendered(figure):
    """Return the picture, uint8 of shape (height, width, 3)."""
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[..., :3]


def axes_image(figure, number, picture):
    """Return the pixels inside the axes of the figure, without a margin for their frame."""
    box = figure.axes[number].get_window_extent()
    height = picture.shape[0]
    return picture[height - int(box.y1) + 3:height - int(box.y0) - 3,
                   int(box.x0) + 3:int(box.x1) - 3]


def test_frame_and_masks_are_in_the_picture():
    image = np.zeros((480, 640, 3), np.uint8)
    image[:, :320], image[:, 320:] = (215, 70, 25), (60, 25, 215)       # blue beside red
    figure, areas_px = tuning_picture.draw(image, ARTICLE)
    assert areas_px == [153600, 153600]
    picture = rendered(figure)
    frame = axes_image(figure, 0, picture)
    third = frame.shape[1] // 3
    assert (frame[:, :third] == (25, 70, 215)).all()
    assert (frame[:, -third:] == (215, 25, 60)).all()
    blue, red = (axes_image(figure, number, picture) for number in (4, 7))
    third = blue.shape[1] // 3
    assert (blue[:, :third] == (25, 70, 215)).all() and (blue[:, -third:] == 0).all()
    assert (red[:, :third] == 0).all() and (red[:, -third:] == (215, 25, 60)).all()


def test_bars_have_the_color_of_their_hue():
    figure, _ = tuning_picture.draw(one_color(110, size=(100, 100)), ARTICLE)
    hues = axes_image(figure, 2, rendered(figure))
    column = round((110 + 1.5) / 183 * (hues.shape[1] + 6)) - 3
    bar = np.array(colorsys.hsv_to_rgb(110 / 180, 1, 225 / 255)) * 255
    assert np.abs(hues[hues.shape[0] // 2, column] - bar).max() < 12


@pytest.mark.parametrize('shape, settings', [
    ((1, 1, 3), FIVE), ((1, 3000, 3), ARTICLE), ((3000, 2, 3), ARTICLE),
    ((1080, 1920, 3), ARTICLE)])
def test_images_of_any_size(shape, settings):
    figure, areas_px = tuning_picture.draw(noise(2, shape), settings)
    assert rendered(figure).shape[1] == 1200
    assert len(areas_px) == len(settings.colors)


@pytest.mark.parametrize('name, settings, shape', [
    ('tuning_two', with_colors(['blue', 'red_and_pink'])(
        red_and_pink_hue_min=170, red_and_pink_hue_max=10, roi_x_offset=20, roi_width=50,
        blue_area_limit=30), (60, 80, 3)),
    ('tuning_five', FIVE, (200, 1100, 3))])
def test_layout_is_as_it_was(name, settings, shape, tmp_path):
    image = noise(3, shape)
    image[:, shape[1] // 2:] = (215, 70, 25)
    figure, _ = tuning_picture.draw(image, settings)
    png = io.BytesIO()
    figure.savefig(png)
    assert_unchanged(of_matplotlib(png.getvalue()),
                     os.path.join(os.path.dirname(__file__), name + '.png'), tmp_path)


@pytest.mark.parametrize('limit_px, ticks', [
    (0, [0, 1]), (1, [0, 1]), (3, [0, 2]), (60, [0, 5, 20, 50])])
def test_scale_reaches_the_area_limit_or_the_highest_bar(limit_px, ticks):
    settings = with_colors(['any'])(any_hue_min=100, any_hue_max=120, any_area_limit=limit_px)
    figure, _ = tuning_picture.draw(np.full((4, 16, 3), 120, np.uint8), settings)
    saturation = figure.axes[5]
    assert saturation.get_ylim() == (0, 1.1) and saturation.texts[0].get_text() == (
        'no pixel has this hue')
    hues = figure.axes[2]
    assert list(hues.get_yticks()) == ticks
    assert hues.get_ylim()[1] == pytest.approx(1.1 * max(1, min(64, limit_px)))
