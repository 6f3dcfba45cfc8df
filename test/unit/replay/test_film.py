"""Films: what is made of their pictures."""
import errno
import subprocess

import numpy as np
import pytest

from img_recog.camera.decoder import open_decoder
from img_recog.errors import UserError
from img_recog.recognition.recognition_settings import with_colors
from img_recog.replay.film import RATE_HZ, Film
from img_recog.replay.film_picture import HEIGHT, WIDTH, FilmPicture
from img_recog_helpers.films import SQUARE, card, frames_of

SETTINGS = with_colors()()


def test_a_film_shows_each_image_until_the_next_one(tmp_path):
    path = tmp_path / 'out.mp4'
    with open(str(path), 'w+b') as file, Film(file, SETTINGS, [SQUARE]) as film:
        film.picture.pose = (1.0, 1.0, 0.0)
        film.add(0.0, card(), 'bgr8')
        film.add(0.5, card((40, 40, 210)), 'bgr8')
        film.close(1.0)
    frames, rate_hz = frames_of(path)
    assert (len(frames), rate_hz) == (RATE_HZ, RATE_HZ)
    blue = [frame[214, 250].tolist() for frame in frames]
    assert all(pixel[0] > 150 for pixel in blue[:14]) and all(pixel[2] > 150
                                                              for pixel in blue[16:])


def test_a_film_has_the_colors_of_its_pictures_and_states_how_they_were_coded(
        tmp_path, monkeypatch):
    path, color = str(tmp_path / 'out.mp4'), (20, 200, 30)
    monkeypatch.setattr(FilmPicture, 'draw', lambda *_: np.full(
        (HEIGHT, WIDTH, 3), color[::-1], np.uint8))
    with open(path, 'w+b') as file, Film(file, SETTINGS, []) as film:
        film.add(0.0, card(), 'bgr8')
        film.close(0.1)
    with open_decoder(path, WIDTH * HEIGHT) as decoder:
        assert np.abs(decoder.read().mean(axis=(0, 1)) - color).max() < 4
    assert subprocess.run(
        ['ffprobe', '-v', 'error', '-show_entries', 'stream=color_space', '-of', 'csv=p=0', path],
        stdout=subprocess.PIPE).stdout.strip() == b'smpte170m'


def test_what_ffmpeg_cannot_encode_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr('img_recog.replay.film._FORMAT', 'yuv1')
    with open(str(tmp_path / 'part'), 'w+b') as file:
        with pytest.raises(UserError, match='^cannot encode the film: [^\n]+; see whether PyAV '
                           'has the encoder libx264'):
            Film(file, SETTINGS, [])


def test_a_full_disk_is_named():
    with open('/dev/full', 'r+b') as file, pytest.raises(OSError) as raised:
        with Film(file, SETTINGS, []) as film:
            for number in range(100):
                film.add(number / RATE_HZ, card(), 'bgr8')
            film.close(100 / RATE_HZ)
    assert (raised.value.errno, raised.value.filename) == (errno.ENOSPC, '/dev/full')
