"""Area limits and blob sizes for areas that are known."""
import numpy as np
import pytest

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.fitting.limits import Areas, Limit, best_size, blobs
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.recognition_settings import with_colors


def areas(seen, unseen):
    found = Areas()
    for area_px in seen:
        found.add(area_px, True)
    for area_px in unseen:
        found.add(area_px, False)
    return found


@pytest.mark.parametrize('seen, unseen, limit, score', [
    ([400, 900], [0, 3], 39, (2, 0, 0)), ([400, 900], [], 19, (2, 0, 0)),
    ([5], [4], 4, (1, 0, 0)), ([0, 100], [0], 9, (1, 0, 1)),
    ([100, 200, 300], [150, 0], 9, (3, 1, 0)), ([0], [7], 7, (0, 0, 1))])
def test_the_limit_is_in_the_middle_of_the_gap(seen, unseen, limit, score):
    found = areas(seen, unseen).limit()
    assert (found.area_px, found.score) == (limit, Score(*score))
    assert areas(seen, unseen).score(limit) == found.score


def test_a_larger_size_has_to_be_better():
    good, bad = Score(9, 0, 0), Score(8, 1, 1)

    def best(first, second, pixels_f1=(0.9, 0.9), size=4):
        return best_size({0: [Limit(50, *first)], size: [Limit(50, *second)]},
                         dict(zip((0, size), pixels_f1)))
    assert best((bad, 9.0), (good, 2.0)) == 4
    assert best((good, 2.0), (good, 2.5)) == 0
    assert best((good, 2.0), (good, 9.0)) == 4
    assert best((bad, 2.0), (good, 9.0), size=64) == 0
    assert best((good, 2.0), (good, 2.0), (0.9, 0.91)) == 4
    assert best((good, 2.0), (good, 2.0), (0.9, 0.901)) == 0
    assert best((good, 2.0), (good, 9.0), (0.9, 0.8)) == 0
    assert best((good, 2.0), (bad, 9.0), (0.9, 0.95)) == 0


def test_areas_of_blobs_are_those_of_the_node():
    image = np.zeros((40, 50, 3), np.uint8)
    image[5:8, 5:8] = image[20:30, 20:31] = image[39, 49] = (215, 70, 25)
    settings = [with_colors(['blue'])(min_blob_size=size) for size in (0, 4, 10)]
    extractor = ColorExtractor(settings[0])
    extractor.measure(image)
    is_color = np.zeros((40, 50), bool)
    is_color[18:30, 20:30] = True
    found = blobs(extractor.mask(0), (0, 4, 10), is_color, ~is_color)
    assert found.areas_px.tolist() == [120, 119, 110] == [
        ColorExtractor(each).measure(image)[0] for each in settings]
    assert found.pixels.tolist() == [[100, 20, 20], [100, 19, 20], [100, 10, 20]]


def test_blobs_without_pixels_or_labels():
    none, all_of_it = np.zeros((1, 1), bool), np.ones((1, 1), bool)
    found = blobs(np.zeros((4, 4), np.uint8), (0, 4), np.ones((4, 4), bool), none)
    assert found.areas_px.tolist() == [0, 0] and found.pixels.tolist() == [[0, 0, 16]] * 2
    assert blobs(np.full((4, 4), 255, np.uint8), (4, 99), none, all_of_it).pixels.tolist() == [
        [0, 16, 0], [0, 0, 0]]
