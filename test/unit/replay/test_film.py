"""Films: what ffmpeg makes of their pictures."""
import errno
import shutil
import subprocess

import numpy as np
import pytest

from img_recog.camera.decoder import open_decoder
from img_recog.errors import UserError
from img_recog.recognition.settings import with_colors
from img_recog.replay.film import RATE_HZ, Film, FilmWriter
from img_recog.replay.film_picture import HEIGHT, WIDTH
from img_recog_testing.films import SQUARE, card, frames_of

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


def test_a_film_has_the_colors_of_its_pictures_and_states_how_they_were_coded(tmp_path):
    path, color = str(tmp_path / 'out.mp4'), (20, 200, 30)
    with open(path, 'w+b') as file:
        writer = FilmWriter(file, WIDTH, HEIGHT, RATE_HZ)
        writer.write(np.full((HEIGHT, WIDTH, 3), color[::-1], np.uint8))
        writer.close()
    with open_decoder(path, WIDTH * HEIGHT) as decoder:
        assert np.abs(decoder.read().mean(axis=(0, 1)) - color).max() < 4
    assert subprocess.run(
        ['ffprobe', '-v', 'error', '-show_entries', 'stream=color_space', '-of', 'csv=p=0', path],
        stdout=subprocess.PIPE).stdout.strip() == b'smpte170m'


def test_without_ffmpeg(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, 'which', lambda _: None)
    with open(str(tmp_path / 'part'), 'w+b') as file:
        with pytest.raises(UserError) as refused:
            FilmWriter(file, WIDTH, HEIGHT, RATE_HZ, 'out.mp4')
    assert str(refused.value) == (
        'cannot write out.mp4: there is no program ffmpeg; install the package ffmpeg')


def test_an_error_of_ffmpeg_is_one_line(tmp_path):
    with open(str(tmp_path / 'part'), 'w+b') as file:
        writer = FilmWriter(file, 0, HEIGHT, RATE_HZ, 'out.mp4')
        with pytest.raises(UserError, match='^cannot write out.mp4: ffmpeg: [^\n]+; see whether '
                           'ffmpeg works and has the encoder libx264: ffmpeg -encoders$'):
            for _ in range(100):
                writer.write(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
            writer.close()


def test_an_error_of_a_real_ffmpeg_on_a_full_disk():
    with open('/dev/full', 'r+b') as file:
        writer = FilmWriter(file, WIDTH, HEIGHT, RATE_HZ)
        with pytest.raises(OSError) as raised:
            for _ in range(100):
                writer.write(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
            writer.close()
    assert (raised.value.errno, raised.value.filename) == (errno.ENOSPC, '/dev/full')
