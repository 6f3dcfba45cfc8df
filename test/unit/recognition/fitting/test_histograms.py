"""Counts of labeled pixels compared with plain numpy."""
import numpy as np
import pytest

from img_recog.recognition.fitting import histograms
from img_recog.recognition.fitting.histograms import (COLOR, IN_VIEW, NOT, SHAPE, UNIT, Counter,
                                                      Label, dense, of_color)

RED, BLUE = Label(COLOR, 'red', ('red',)), Label(COLOR, 'blue', ('blue',))
NONE = Label(NOT, '')


def pixels(seed, count=500):
    return (np.random.RandomState(seed).rand(count, 3) * SHAPE).astype(np.uint8)


def plain(*parts):
    counts = np.zeros(SHAPE, np.int64)
    np.add.at(counts, tuple(np.concatenate(parts).T), 1)
    return counts


def counted(*frames):
    counter = Counter()
    for parts in frames:
        counter.add_frame(parts)
    return counter.result()


@pytest.mark.parametrize('batch_px', [7, 600, 1 << 24])
def test_counts_are_exact_whatever_is_counted_at_a_time(monkeypatch, batch_px):
    monkeypatch.setattr(histograms, '_BATCH_PX', batch_px)
    found = counted([(RED, pixels(0, 30)), (NONE, pixels(1, 40))], [(NONE, pixels(2, 20))])
    assert (dense(found.pixels[RED]) == plain(pixels(0, 30))).all()
    assert (dense(found.pixels[NONE]) == plain(pixels(1, 40), pixels(2, 20))).all()
    assert found.frames == {RED: 1, NONE: 2}


def test_histograms_add_up_in_any_order():
    parts = [counted([(RED, pixels(seed)), (Label(NOT, '', ('red',)), pixels(seed + 10))])
             for seed in range(3)]
    sums = []
    for order in ((0, 1, 2), (2, 0, 1)):
        total = Counter()
        for number in order:
            total.add_result(parts[number])
        sums.append(total.result())
    assert (dense(sums[0].pixels[RED]) == plain(*map(pixels, range(3)))).all()
    for label, histogram in sums[0].pixels.items():
        assert (histogram.indices == sums[1].pixels[label].indices).all()
        assert (histogram.counts == sums[1].pixels[label].counts).all()
    assert sums[0].frames == sums[1].frames == {RED: 3, Label(NOT, '', ('red',)): 3}


def test_other_colors_are_not_the_color_and_frames_without_it_are_weighted():
    not_red = Label(NOT, 'red', ('blue',))
    red, near, blue, other = (pixels(seed) for seed in range(4))
    found = counted([(RED, red), (Label(NOT, '', ('red',)), near)],
                    *[[(BLUE, blue), (not_red, other)]] * 4)
    sampled = of_color(found, 'red')
    assert (sampled.positive == UNIT * plain(red)).all()
    # there are four frames without red, and one with it
    assert (sampled.negative == UNIT * plain(near) + UNIT // 4 * plain(*[blue, other] * 4)).all()
    blues = of_color(found, 'blue')
    assert (blues.positive == UNIT * plain(*[blue] * 4)).all()
    assert (blues.negative == UNIT * plain(red, near)).all()


def test_pixels_of_a_color_are_estimated_from_times_when_it_is_in_view():
    background, card = pixels(0), np.full((300, 3), 100, np.uint8)
    seen = Label(IN_VIEW, 'red', ('red',))
    sampled = of_color(counted([(seen, np.concatenate([background[:200], card]))],
                               [(NONE, background)]), 'red')
    assert sampled.positive[100, 100, 100] == 300 * UNIT
    assert (sampled.positive != 0).sum() < 5
    assert not of_color(counted([(NONE, background)]), 'red').positive.any()


def test_hues_of_opencv_end_at_179():
    import cv2
    levels = np.arange(0, 256, 5, dtype=np.uint8)
    image = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 1, 3)
    assert cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[..., 0].max() == SHAPE[0] - 1
