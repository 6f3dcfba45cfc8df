"""The search of the best box compared with all boxes there are."""
import functools

import numpy as np
import pytest

from img_recog.recognition.fitting.boxes import BoxSearch
from img_recog.recognition.fitting.volume import SummedVolume, sparse


@functools.lru_cache(maxsize=None)
def all_boxes(shape):
    ranges = [[(low, low + size) for low in range(shape[0]) for size in range(1, shape[0] + 1)]]
    ranges += [[(low, end) for low in range(size) for end in range(low + 1, size + 1)]
               for size in shape[1:]]
    numbers = np.indices([len(each) for each in ranges]).reshape(3, -1)
    return np.concatenate([np.array(sides)[chosen] for sides, chosen in zip(ranges, numbers)], 1)


def search(positive, negative):
    return BoxSearch(sparse(positive), sparse(negative), positive.shape)


def brute_force(positive, negative, beta=1.0):
    edges = all_boxes(positive.shape)
    inside, wrong = (SummedVolume(sparse(counts), counts.shape).count(edges)
                     for counts in (positive, negative))
    return ((1 + beta ** 2) * inside / np.maximum(
        1, beta ** 2 * positive.sum() + inside + wrong)).max()


def blob(shape, seed, through_zero):
    """Return two histograms that overlap: a color in a part of the bins, and others everywhere."""
    random = np.random.RandomState(seed)
    positive, negative = random.poisson(0.3, shape), random.poisson(1.0, shape)
    middle = 0 if through_zero else shape[0] // 2
    hues = np.arange(middle - 2, middle + 2) % shape[0]
    positive[hues, shape[1] // 2:, 1:shape[2] - 1] += random.poisson(4.0, positive[
        hues, shape[1] // 2:, 1:shape[2] - 1].shape)
    return positive, negative


@pytest.mark.parametrize('beta', [0.5, 1.0, 2.0])
@pytest.mark.parametrize('through_zero', [False, True])
@pytest.mark.parametrize('seed', range(4))
def test_no_box_is_better_than_the_one_that_is_found(seed, through_zero, beta):
    positive, negative = blob((12, 6, 6), seed, through_zero)
    found = search(positive, negative).best(beta)
    assert found.score == pytest.approx(brute_force(positive, negative, beta), abs=1e-12)
    assert found.score == pytest.approx(
        float(search(positive, negative).objective(beta).score(found.edges)))


@pytest.mark.parametrize('seed', range(3))
def test_no_box_is_better_where_the_first_search_has_coarser_bins(seed):
    # 60, 32 and 16 of 30, 16 and 16 bins
    positive, negative = blob((60, 32, 16), seed, seed % 2 == 0)
    small = [counts.reshape(30, 2, 8, 4, 8, 2).sum(axis=(1, 3, 5))
             for counts in (positive, negative)]
    found = search(positive, negative).best()
    assert found.score >= brute_force(*small) - 1e-12


# of these seeds, one axis after the other does not lead to the best box
@pytest.mark.parametrize('seed', [1, 3, 4, 6, 15, 18, 20, 26, 27, 28, 32, 35])
def test_a_few_pixels_in_noise_are_searched_as_well(seed):
    random = np.random.RandomState(seed)
    positive, negative = random.poisson(0.06, (12, 6, 6)), random.poisson(1.0, (12, 6, 6))
    assert search(positive, negative).best().score == pytest.approx(
        brute_force(positive, negative))


# of these seeds, too, and all levels at which there are pixels of either matter
@pytest.mark.parametrize('seed, margin', [
    (54, (0, 0, 0)), (104, (0, 0, 0)), (277, (0, 2, 0))])
def test_levels_without_pixels_are_not_searched_one_by_one(seed, margin):
    random = np.random.RandomState(seed)
    positive, negative = np.zeros((2, 8, 9, 5), int)
    positive[:, ::3, ::2] = random.poisson(0.1, (8, 3, 3))
    negative[:, 1::3, 1::2] = random.poisson(1.0, (8, 3, 2))
    found = search(positive, negative)
    assert found.best(margin=margin).score == pytest.approx(
        found.objective(1.0, margin).score(all_boxes(positive.shape)).max())


def plain_count(counts, edges, by):
    """Return the counts in a box whose sides are moved outwards, but for those at an end."""
    low, end = edges[:2]
    inside = [sorted({hue % counts.shape[0] for hue in (
        range(low - by[0], end + by[0]) if end - low < counts.shape[0] else range(low, end))})]
    for axis, size in enumerate(counts.shape[1:], 1):
        low, end = edges[2 * axis:2 * axis + 2]
        moved = range(low - by[axis] * (low > 0), end + by[axis] * (end < size))
        inside.append([level for level in moved if 0 <= level < size])
    return counts[np.ix_(*inside)].sum()


@pytest.mark.parametrize('beta, margin', [(1.0, (0, 0, 0)), (2.0, (2, 1, 0)), (0.5, (1, 0, 2))])
def test_scores_are_those_of_plain_numpy(beta, margin):
    positive, negative = blob((12, 6, 5), 1, True)
    edges = np.random.RandomState(2).permutation(all_boxes(positive.shape))[:300]
    scores = search(positive, negative).objective(beta, margin).score(edges)
    for each, score in zip(edges.tolist(), scores):
        inside = plain_count(positive, each, [-by for by in margin])
        wrong = plain_count(negative, each, margin)
        assert score == pytest.approx((1 + beta ** 2) * inside / (
            beta ** 2 * positive.sum() + inside + wrong))


@pytest.mark.parametrize('margin', [(0, 0, 0), (2, 1, 1)])
def test_scores_of_boxes_that_differ_in_one_axis_are_theirs(margin):
    objective = search(*blob((12, 6, 6), 0, True)).objective(1.0, margin)
    edges = all_boxes((12, 6, 6))[::500]
    for axis in range(3):
        boxes = np.tile(edges[7], (len(edges), 1))
        boxes[:, 2 * axis:2 * axis + 2] = sides = edges[:, 2 * axis:2 * axis + 2]
        assert (objective.scores_along(axis, edges[7], sides.T) == objective.score(boxes)).all()


def test_a_margin_keeps_sides_away_from_both():
    positive, negative = np.zeros((2, 180, 256, 256), int)
    positive[20:30, 150:200, 150:200] = 1
    negative[0:10, 150:200, 150:200] = negative[60:70, 150:200, 150:200] = 1
    found = search(positive, negative)
    wide = found.best(margin=(4, 16, 16))
    assert wide.score == 1.0
    low, end = wide.edges[:2]
    assert 10 + 4 <= low <= 20 - 4 and 30 + 4 <= end <= 60 - 4
    assert wide.edges[2] <= 150 - 16 and (wide.edges[3] >= 200 + 16 or wide.edges[3] == 256)
    # a margin that is wider than the gap costs pixels
    assert found.best(margin=(8, 0, 0)).score < 1.0
