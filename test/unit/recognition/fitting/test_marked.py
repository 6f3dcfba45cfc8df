"""Samples that are marked in pictures: regions, what is refused, and the files of them."""
import cv2
import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.fitting import marked, sample_file
from img_recog.recognition.fitting.frame_labels import Labeler
from img_recog.recognition.fitting.marked import Marked
from img_recog.recognition.fitting.samples import SampleError

HEIGHT, WIDTH = 120, 160
RED, BLUE = (40, 30, 190), (170, 80, 30)        # BGR
RED_PLACE, BLUE_PLACE = (40 / WIDTH, 60 / HEIGHT), (120 / WIDTH, 60 / HEIGHT)


def truth(center):
    return cv2.circle(np.zeros((HEIGHT, WIDTH), np.uint8), center, 25, 1, -1) > 0


def scene():
    """Return a red and a blue ball in a shadow, before a gray wall with a wooden stripe."""
    image = np.full((HEIGHT, WIDTH, 3), 150.0)
    image[:20] = (120, 160, 210)
    image[truth((40, 60))], image[truth((120, 60))] = RED, BLUE
    image *= np.linspace(0.8, 1.2, WIDTH)[:, None]
    image += np.random.RandomState(1).normal(0, 5, image.shape)
    return image.clip(0, 255).astype(np.uint8)


@pytest.fixture
def kept():
    """A picture, and its name."""
    return marked.with_picture(Marked(), scene())


@pytest.mark.parametrize('place, center', [(RED_PLACE, (40, 60)), (BLUE_PLACE, (120, 60))])
def test_a_click_marks_the_object(kept, place, center):
    found = marked.with_click(*kept, *place, 'red').as_samples()
    labels = Labeler(found, kept[1]).of(0, 0.0, (HEIGHT, WIDTH))
    inside, ball = labels.truth(0)[0], truth(center)
    assert (inside & ball).sum() > 0.95 * (inside | ball).sum()


def test_a_click_on_gray_marks_gray_of_any_hue(kept):
    sample, = marked.with_click(*kept, 80 / WIDTH, 100 / HEIGHT, 'none').samples
    wall = HEIGHT * WIDTH - 20 * WIDTH - 2 * truth((40, 60)).sum()
    assert sample.area_px == pytest.approx(wall, rel=0.05)


def test_a_region_leaves_out_what_is_marked(kept):
    now = marked.with_rectangle(*kept, 30 / WIDTH, 50 / HEIGHT, 20 / WIDTH, 20 / HEIGHT, 'blue')
    now = marked.with_click(now, kept[1], 40 / WIDTH, 75 / HEIGHT, 'red')
    first, second = now.samples
    assert first.rectangle == (30, 50, 20, 20) and first.area_px == 400
    assert second.area_px == pytest.approx(truth((40, 60)).sum() - 400, rel=0.05)


@pytest.mark.parametrize('place', [(-0.01, 0.5), (0.5, 1.01), (float('nan'), 0.5),
                                   (0.5, 0.5, 0.6, 0.1), (0.5, 0.5, 0.1, float('inf'))])
def test_a_place_outside_of_the_picture_is_refused(kept, place):
    add = marked.with_click if len(place) == 2 else marked.with_rectangle
    with pytest.raises(UserError, match='this is outside of the picture'):
        add(*kept, *place, 'red')


@pytest.mark.parametrize('place, problem', [
    ((0.5, 0.5, 0.0, 0.2), 'the rectangle has 0x24 pixels, at least 30 are needed'),
    ((0.5, 0.5, -0.2, 0.2), 'the rectangle has 0x24 pixels'),
    ((0.5, 0.5, 0.01, 0.01), 'the rectangle has 2x1 pixels'),
    ((1.0, 1.0, 0.0, 0.0), 'the rectangle has 1x1 pixels')])
def test_an_empty_rectangle_is_refused(kept, place, problem):
    with pytest.raises(UserError, match=problem):
        marked.with_rectangle(*kept, *place, 'red')


def test_a_speck_is_refused():
    image = np.full((HEIGHT, WIDTH, 3), 150, np.uint8)
    image[50:54, 50:54] = RED
    with pytest.raises(UserError, match='only 4 connected pixels .*drag a rectangle'):
        marked.with_click(*marked.with_picture(Marked(), image), 52 / WIDTH, 52 / HEIGHT, 'red')


def test_the_same_pixels_cannot_be_of_two_colors(kept):
    now = marked.with_rectangle(*kept, 0.1, 0.1, 0.4, 0.5, 'red')
    with pytest.raises(SampleError, match=r'sample 1 and sample 2 contradict each other: 25\.0% '
                                          'of sample 2 is red by the one and blue by the other'):
        marked.with_rectangle(now, kept[1], 0.4, 0.1, 0.4, 0.5, 'blue')
    with pytest.raises(UserError, match='this is sample 1 already, which is red; remove it'):
        marked.with_click(now, kept[1], 0.2, 0.3, 'blue')
    now = marked.without(now, 1)
    assert [each.number for each in marked.with_rectangle(
        now, kept[1], 0.4, 0.1, 0.4, 0.5, 'blue').samples] == [2]


def test_pictures_and_samples_are_limited(kept, monkeypatch):
    now, name = kept
    for number in range(marked.MAX_SAMPLES):
        now = marked.with_rectangle(now, name, 0.1, 0.1, 0.2, 0.2, 'red')
    with pytest.raises(UserError, match='there are 40 samples already'):
        marked.with_rectangle(now, name, 0.1, 0.1, 0.2, 0.2, 'red')
    now = marked.with_rectangle(*kept, 0.1, 0.1, 0.2, 0.2, 'red')
    for number in range(marked.MAX_PICTURES - 1):
        now, name = marked.with_picture(now, scene())
        now, name = marked.with_picture(now, scene())       # without samples, the last one goes
        now = marked.with_rectangle(now, name, 0.1, 0.1, 0.2, 0.2, 'red')
    assert len(now.pictures) == marked.MAX_PICTURES
    with pytest.raises(UserError, match='at most 8 pictures with 64 MB are kept'):
        marked.with_picture(now, scene())
    monkeypatch.setattr(marked, '_MAX_BYTES', 1000)
    with pytest.raises(UserError, match='at most 8 pictures'):
        marked.with_picture(Marked(), scene())
    with pytest.raises(UserError, match='no longer kept'):
        marked.with_click(now, 'picture_2.png', 0.5, 0.5, 'red')


@pytest.mark.parametrize('rest_is_none', [True, False])
def test_the_files_say_the_same(kept, tmp_path, rest_is_none):
    now = marked.with_click(*kept, *RED_PLACE, 'red')
    now = marked.with_rectangle(now, kept[1], 0.6, 0.3, 0.2, 0.4, 'blue')
    now = marked.with_click(now, kept[1], 80 / WIDTH, 100 / HEIGHT, 'none')
    now, unused = marked.with_picture(now._replace(rest_is_none=rest_is_none), scene())
    marked.write(now, str(tmp_path))
    read = sample_file.read(str(tmp_path / 'samples.yaml'))
    assert not (tmp_path / unused).exists()
    assert (cv2.imread(str(tmp_path / kept[1])) == now.image(kept[1])).all()
    labels = [Labeler(each, kept[1]).of(0, 0.0, (HEIGHT, WIDTH))
              for each in (read, now.as_samples())]
    assert read.colors == now.colors == ('red', 'blue')
    for number in (0, 1):
        for of_file, of_page in zip(*(each.truth(number) for each in labels)):
            assert (of_file == of_page).all() and of_page.any()
    assert labels[0].truth(0)[1].sum() > 100


def test_lines_around_the_samples(kept):
    now = marked.with_click(*kept, *RED_PLACE, 'red')
    now = marked.with_rectangle(now, kept[1], 0.6, 0.3, 0.2, 0.4, 'blue')
    ball, rectangle = marked.outlines(now, kept[1])
    assert len(ball) < 60
    for x, y in ball:
        assert np.hypot(x * WIDTH - 40.5, y * HEIGHT - 60.5) == pytest.approx(25, abs=2.5)
    # from the middle of the first pixel to that of the last one
    assert [(x * WIDTH, y * HEIGHT) for x, y in sorted(rectangle)] == [
        pytest.approx(corner, abs=0.02) for corner in (
            (96.5, 36.5), (96.5, 83.5), (127.5, 36.5), (127.5, 83.5))]
