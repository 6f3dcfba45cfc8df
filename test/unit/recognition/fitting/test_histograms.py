"""Counts of labeled pixels compared with plain numpy."""
import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.fitting import histograms
from img_recog.recognition.fitting.histograms import (COLOR, IN_VIEW, NOT, SHAPE, UNIT, Counter,
                                                      Label, of_color)

RED, BLUE = Label(COLOR, 'red', ('red',)), Label(COLOR, 'blue', ('blue',))
NONE = Label(NOT, '')


def pixels(seed, count=500):
    return (np.random.RandomState(seed).rand(count, 3) * SHAPE).astype(np.uint8)


def plain(*parts):
    counts = np.zeros(SHAPE, np.int64)
    np.add.at(counts, tuple(np.concatenate(parts).T), 1)
    return counts


def dense(histogram):
    counts = np.zeros(SHAPE, np.int64)
    counts.reshape(-1)[histogram.indices] = histogram.counts
    return counts


def counted(*frames):
    counter = Counter()
    for parts in frames:
        counter.add_frame(parts)
    return counter.result()


@pytest.mark.parametrize('batch_px, few_px', [(7, 5), (600, 0), (1 << 24, 60)])
def test_counts_are_exact_whatever_is_counted_at_a_time(monkeypatch, batch_px, few_px):
    monkeypatch.setattr(histograms, '_BATCH_PX', batch_px)
    monkeypatch.setattr(histograms, '_FEW_PX', few_px)
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
    assert (dense(sampled.positive) == UNIT * plain(red)).all()
    # there are four frames without red, and one with it
    assert (dense(sampled.negative) == (
        UNIT * plain(near) + UNIT // 4 * plain(*[blue, other] * 4))).all()
    blues = of_color(found, 'blue')
    assert (dense(blues.positive) == UNIT * plain(*[blue] * 4)).all()
    assert (dense(blues.negative) == UNIT * plain(red, near)).all()


def seen_and_unseen(*others):
    """Return histograms of frames with a red card and with each of these, and without any color.

    others: tuples of the other colors that are in view, and whether red is.
    """
    background = np.full((700, 3), (20, 10, 120), np.uint8)
    card = {'red': (178, 200, 150), 'blue': (115, 200, 150)}
    frames = []
    for names, is_red in others:
        in_view = tuple(sorted((*names, *['red'] * is_red)))
        shown = np.concatenate([background, *(np.full((300, 3), card[name], np.uint8)
                                              for name in in_view)])
        frames.append([(Label(IN_VIEW, name, in_view), shown) for name in in_view]
                      + [(Label(NOT, name, in_view), shown) for name in card
                         if name not in in_view])
    return counted(*frames)


@pytest.mark.parametrize('others', [
    [((), True), ((), False)], [((), True), (('blue',), False)],
    # blue is in view more often with red than without it
    [(('blue',), True), (('blue',), True), (('blue',), False), ((), False), ((), False)],
    # a frame with both is not used if none has blue alone
    [((), True), (('blue',), True), ((), False)]])
@pytest.mark.parametrize('uses_brightness', [False, True])
def test_of_times_the_color_is_what_only_frames_with_it_have(others, uses_brightness):
    positive = dense(of_color(seen_and_unseen(*others), 'red', uses_brightness).positive)
    assert positive[178, 200, 150] > 0 and np.count_nonzero(positive) == 1
    # as if all frames with it were used
    used = sum(is_red for _, is_red in others)
    assert positive.sum() == pytest.approx(300 * UNIT * used, rel=0.35)


@pytest.mark.parametrize('others, words', [
    ([((), True)], 'there is no time without red; add one: not_in_view'),
    ([(('blue',), True), ((), False)], 'whenever red is in view, blue is too, and never alone')])
def test_times_that_do_not_tell_a_color(others, words):
    with pytest.raises(UserError, match=words):
        of_color(seen_and_unseen(*others), 'red')


def test_pixels_without_a_color_are_no_time_without_it():
    found = counted([(Label(IN_VIEW, 'red', ('red',)), pixels(0)),
                     (Label(NOT, '', ('red',)), pixels(1))])
    with pytest.raises(UserError, match='there is no time without red'):
        of_color(found, 'red')


def test_a_color_of_which_nothing_is_known_has_no_pixels():
    assert not of_color(counted([(NONE, pixels(0))]), 'red').positive.counts.any()


def test_hues_of_opencv_end_at_179():
    import cv2
    levels = np.arange(0, 256, 5, dtype=np.uint8)
    image = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 1, 3)
    assert cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[..., 0].max() == SHAPE[0] - 1
