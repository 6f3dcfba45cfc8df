"""Bounds for histograms that are known, and for pictures made in five lights."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.fitting import bounds
from img_recog.recognition.fitting.histograms import (COLOR, NOT, SHAPE, UNIT, Counter, Label,
                                                      Sampled, of_color)
from img_recog.recognition.fitting.volume import Box, SummedVolume, sparse
from img_recog_helpers.refusals import refusal

RED, BLUE = (40, 30, 190), (170, 80, 30)       # BGR, of cards
OTHERS = ((70, 110, 160), (60, 130, 60), (130, 130, 130), (60, 60, 60), (120, 160, 210),
          (70, 190, 220))                      # skin, plants, walls, floor, wood, a yellow cup
# color temperature (gains of blue, green and red), exposure, noise
LIGHTS = [((1.0, 1.0, 1.0), 1.0, 3.0), ((0.75, 0.95, 1.15), 0.7, 6.0),
          ((1.2, 1.0, 0.85), 1.2, 4.0), ((0.85, 0.97, 1.08), 1.1, 8.0),
          ((1.1, 1.0, 0.92), 0.8, 5.0)]
PLACES = {'red': (slice(60, 100), slice(20, 80)), 'blue': (slice(60, 100), slice(100, 150))}


def scene(light, seed=0):
    """Return a frame of a red and a blue card before stripes of other colors, in a light."""
    gains, exposure, noise = light
    random = np.random.RandomState(seed)
    image = np.zeros((120, 180, 3))
    for number, color in enumerate(OTHERS):
        image[:, 30 * number:30 * number + 30] = color
    for name, color in (('red', RED), ('blue', BLUE)):
        image[PLACES[name]] = color
    image = image * np.linspace(0.85, 1.1, 120)[:, None, None]      # a shadow
    image = image * gains * exposure + random.normal(0, noise, image.shape)
    return image.clip(0, 255).astype(np.uint8)


def sampled(numbers, name):
    counter = Counter()
    for number in numbers:
        hsv = cv2.cvtColor(scene(LIGHTS[number], number), cv2.COLOR_BGR2HSV)
        inside = np.zeros(hsv.shape[:2], bool)
        inside[PLACES[name]] = True
        counter.add_frame([(Label(COLOR, name, (name,)), hsv[inside]),
                           (Label(NOT, '', (name,)), hsv[~inside])])
    return of_color(counter.result(), name)


@pytest.mark.parametrize('name, article', [('red', Box((150, 180), (100, 255), (150, 255))),
                                           ('blue', Box((50, 150), (100, 255), (100, 255)))])
def test_bounds_of_three_lights_hold_in_two_others(name, article):
    fit, = bounds.fits(name, sampled((0, 1, 2), name))
    other = [SummedVolume(each, SHAPE) for each in sampled((3, 4), name)]
    score = bounds.score_of(fit.box, *other)
    assert score.precision > 0.98 and score.recall > 0.98
    assert score.f1 > bounds.score_of(article, *other).f1 + 0.1


def counts(*parts):
    """Return a histogram with UNIT in boxes, (low, end) of hue, saturation and value."""
    found = np.zeros(SHAPE, np.int64)
    for hue, saturation, value in parts:
        found[slice(*hue), slice(*saturation), slice(*value)] = UNIT
    return found


def as_sampled(*histograms):
    return Sampled(*map(sparse, histograms))


CARD = ((100, 104), (180, 190), (150, 160))


@pytest.mark.parametrize('others, box, margin', [
    # halfway to others; up to the end of the scale where there are none above
    ([((100, 104), (180, 190), (90, 110))], Box((90, 113), (120, 255), (130, 255)),
     (10, 60, 20)),
    ([((110, 120), (0, 256), (0, 256)), ((90, 94), (0, 256), (0, 256))],
     Box((97, 106), (120, 255), (90, 255)), (3, 60, 60)),
    ([((0, 180), (200, 210), (0, 256))], Box((90, 113), (120, 194), (90, 255)), (10, 5, 60)),
    ([], Box((90, 113), (120, 255), (90, 255)), (10, 60, 60))])
def test_bounds_are_in_the_middle_of_gaps(others, box, margin):
    fit, = bounds.fits('blue', as_sampled(counts(CARD), counts(*others)))
    assert fit == (box, (400, 0, 0), margin)


def test_bounds_through_zero():
    red = counts(((176, 180), (180, 190), (150, 160)), ((0, 4), (180, 190), (150, 160)))
    fit, = bounds.fits('red', as_sampled(red, counts(((20, 30), (0, 256), (0, 256)))))
    assert fit.box.hue == (166, 11) and fit.score == (800, 0, 0)


@pytest.mark.parametrize('first', [0, 3, 176])
def test_bounds_of_hues_near_zero_do_not_take_in_brighter_pixels(first):
    hues = [(first, min(first + 8, 180))] + [(0, first + 8 - 180)] * (first > 172)
    card = counts(*(((low, end), (180, 190), (30, 40)) for low, end in hues))
    wall = counts(*(((low, end), (180, 190), (90, 160)) for low, end in hues))
    fit, = bounds.fits('dark', as_sampled(card, wall))
    assert fit.score == (800, 0, 0) and fit.box.value == (15, 64)


def test_a_few_stray_pixels_do_not_widen_the_bounds():
    card = counts(CARD)
    card[0, 255, 255] = UNIT
    fit, = bounds.fits('blue', as_sampled(card, counts(((0, 20), (0, 256), (0, 256)))))
    assert fit.box.hue == (90, 113) and fit.score == (400, 0, 1)


def test_the_objective_margin_gives_up_pixels_for_a_wider_margin():
    card = counts(CARD, ((96, 97), (180, 184), (150, 154)))
    others = counts(((95, 96), (0, 256), (0, 256)), ((112, 113), (0, 256), (0, 256)))
    pixels, = bounds.fits('blue', as_sampled(card, others))
    margin, = bounds.fits('blue', as_sampled(card, others), 'margin')
    assert pixels.box.hue[0] == 96 and pixels.score.missed == 0
    assert margin.box.hue[0] > 97 and margin.score.missed == 16
    assert margin.margin[0] > pixels.margin[0]


def test_the_objective_frames_has_bounds_for_different_weights_of_recall():
    card, others = counts(((100, 108), (180, 190), (150, 160))), counts()
    for hue, share in zip(range(104, 108), (0.15, 0.8, 3.5, 15)):
        others[hue, 180:190, 150:160] = share * UNIT
    found = bounds.fits('blue', as_sampled(card, others), 'frames')
    # the objective `pixels` first
    assert [fit.score.found for fit in found] == [600, 400, 500, 700, 800]


def test_no_sample_and_no_bounds_are_one_line_each():
    assert 'no pixel is a sample of red; add a rectangle' in refusal(
        bounds.fits, 'red', as_sampled(counts(), counts(CARD)))
    line = refusal(bounds.fits, 'red', as_sampled(counts(CARD), 9 * counts(CARD)))
    assert 'no bounds separate red' in line
    assert 'have a precision of 10% and a recall of 100%' in line
    assert '100% of its pixels have a color that others have too' in line
    assert 'most at hue 100, saturation 180, value 150' in line


def test_parameters_of_bounds():
    assert bounds.as_parameters('a', Box((10, 50), (0, 179), (7, 255))) == {
        'a_hue_min': 10, 'a_hue_max': 50, 'a_saturation_min': 0, 'a_saturation_max': 179,
        'a_value_min': 7, 'a_value_max': 255}
