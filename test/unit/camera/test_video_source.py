"""Films and still images: equal to what OpenCV reads, looped without a seam."""
import os

import cv2
import numpy as np
import pytest

from img_recog.camera.selection import open_file
from img_recog.camera.source import SourceError
from img_recog_testing.videos import FILM_RATE_HZ, smooth_image


def film_frames(path):
    """Every frame of a film as OpenCV's own VideoCapture reads it, turned to rgb8."""
    capture, frames = cv2.VideoCapture(path, cv2.CAP_FFMPEG), []
    good, image = capture.read()
    while good:
        frames.append(image[..., ::-1].copy())
        good, image = capture.read()
    return frames


@pytest.mark.parametrize('fourcc, name', [
    ('MJPG', 'film.avi'), ('FFV1', 'film.avi'), ('FFV1', 'film.mkv'), ('mp4v', 'film.mp4')])
def test_film_equals_videocapture_and_loops_without_a_seam(make_film, fourcc, name):
    path = make_film(name, fourcc)
    expected, source = film_frames(path), open_file(path, 30.0)
    assert len(expected) == 6
    for turn in range(3):
        for number, image in enumerate(expected):
            assert np.array_equal(source.read(), image), (turn, number)
    source.close()


def test_frames_of_a_film_are_told_apart_and_have_their_colours(make_film):
    source = open_file(make_film(), 30.0)
    for number in list(range(6)) * 2:
        wanted = smooth_image(number)[..., ::-1].astype(int)
        assert np.abs(source.read() - wanted).mean() < 3.0, number
    source.close()


def test_film_has_its_own_size_and_rate(make_film):
    path = make_film(size=(80, 48))
    source = open_file(path, 30.0)
    assert (source.width, source.height, source.encoding) == (80, 48, 'rgb8')
    assert source.rate_hz == FILM_RATE_HZ
    assert source.read().shape == (48, 80, 3)
    assert source.description == 'film {}, 80x48, 12.5 Hz, played in a loop'.format(path)
    source.close()


def test_film_of_one_frame_repeats_it(make_film):
    path = make_film(frames=1)
    source = open_file(path, 30.0)
    for _ in range(4):
        assert np.array_equal(source.read(), film_frames(path)[0])
    source.close()


def test_frames_of_a_film_belong_to_the_caller(make_film):
    path = make_film()
    source = open_file(path, 30.0)
    for image in film_frames(path):
        frame = source.read()
        assert np.array_equal(frame, image)
        frame[:] = 0
    source.close()


def test_looping_and_closing_leave_no_file_open(make_film):
    path = make_film()

    def times_open():
        links = ('/proc/self/fd/' + number for number in os.listdir('/proc/self/fd'))
        return sum(os.path.realpath(link) == os.path.realpath(path) for link in links)

    source = open_file(path, 30.0)
    for _ in range(30):
        source.read()
        assert times_open() == 1
    source.close()
    source.close()
    assert times_open() == 0


def test_film_that_is_removed_while_it_plays_ends_with_one_line(make_film):
    path = make_film()
    source = open_file(path, 30.0)
    os.remove(path)
    for _ in range(5):
        source.read()
    with pytest.raises(SourceError) as refused:
        source.read()
    assert str(refused.value) == path + ' can no longer be read: moved or replaced while it played'
    source.close()


def test_film_that_is_replaced_by_one_of_another_size_ends(make_film):
    path = make_film()
    source = open_file(path, 30.0)
    os.replace(make_film('other.avi', size=(80, 48)), path)
    for _ in range(5):
        assert source.read().shape == (64, 96, 3)
    with pytest.raises(SourceError, match='can no longer be read'):
        source.read()
    source.close()


@pytest.mark.parametrize('name', ['still.png', 'still.bmp'])
def test_still_image_equals_bit_for_bit_and_repeats(tmp_path, name):
    path, image = str(tmp_path / name), np.random.RandomState(1).randint(0, 256, (31, 47, 3))
    assert cv2.imwrite(path, image.astype(np.uint8)[..., ::-1])
    source = open_file(path, 7.5)
    assert (source.width, source.height, source.encoding) == (47, 31, 'rgb8')
    assert source.rate_hz == 7.5
    assert source.description == 'still image {}, 47x31, 7.5 Hz'.format(path)
    for _ in range(3):
        frame = source.read()
        assert frame.dtype == np.uint8 and np.array_equal(frame, image)
        with pytest.raises(ValueError, match='read-only'):
            frame[:] = 0
    source.close()
    source.close()


@pytest.mark.parametrize('kind', ['grey', 'alpha'])
def test_still_image_of_another_kind_becomes_rgb8(tmp_path, kind):
    path, grey = str(tmp_path / 'still.png'), np.arange(48, dtype=np.uint8).reshape(6, 8)
    image = grey if kind == 'grey' else np.dstack([grey, grey, grey, np.full_like(grey, 9)])
    assert cv2.imwrite(path, image)
    assert np.array_equal(open_file(path, 30.0).read(), np.dstack([grey, grey, grey]))
