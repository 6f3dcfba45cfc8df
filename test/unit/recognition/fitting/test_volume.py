"""Counts of boxes compared with sums of plain numpy."""
import numpy as np
import pytest

from img_recog.recognition.fitting.volume import Box, SummedVolume, box_of, edges_of, sparse

SHAPE = 12, 7, 5


def plain(counts, edges):
    hues = np.arange(edges[0], edges[1]) % counts.shape[0]
    return counts[hues][:, edges[2]:edges[3], edges[4]:edges[5]].sum()


@pytest.mark.parametrize('largest', [9, 1 << 33], ids=['32 bit', '64 bit'])
def test_any_box_is_counted_also_through_zero(largest):
    random = np.random.RandomState(1)
    counts = random.randint(0, largest, SHAPE)
    starts = np.stack([random.randint(0, size, 300) for size in SHAPE], axis=1)
    ends = np.minimum(starts + [[12, 4, 3]], [[24, 7, 5]])
    edges = np.stack([starts, ends], axis=2).reshape(300, 6)
    volume = SummedVolume(sparse(counts), SHAPE)
    assert list(volume.count(edges)) == [plain(counts, each) for each in edges]
    assert volume.total == counts.sum()
    for axis in range(3):       # of the first box, and its sides on the axis those of each
        boxes = np.tile(edges[0], (300, 1))
        boxes[:, 2 * axis:2 * axis + 2] = sides = edges[:, 2 * axis:2 * axis + 2]
        assert list(volume.count_along(axis, edges[0], sides.T)) == [
            plain(counts, each) for each in boxes]


def test_a_box_that_ends_before_it_begins_is_empty():
    volume = SummedVolume(sparse(np.ones(SHAPE, int)), SHAPE)
    empty = np.array([5, 3, 0, 7, 0, 5])
    assert volume.count(empty) == 0
    assert list(volume.count_along(0, empty, np.array([[5, 3], [3, 5]]))) == [0, 70]
    assert list(volume.count_along(1, empty, np.array([[0], [7]]))) == [0]
    assert volume.count(np.array([[[3, 5, 2, 2, 0, 5]]])).shape == (1, 1)


@pytest.mark.parametrize('hue', [(0, 179), (170, 10), (50, 150), (179, 0), (7, 7)])
def test_edges_and_boxes(hue):
    box = Box(hue, (3, 255), (0, 200))
    assert box_of(edges_of(box, 180), 180) == box
    assert edges_of(Box((50, 180), (0, 255), (0, 255)), 180)[1] == 180
