"""From video_device to a frame source."""
import cv2
import numpy as np
import pytest
from films import smooth_image

from img_recog.camera import selection
from img_recog.camera.opencv_source import FilmSource, StillSource
from img_recog.camera.selection import open_source
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import SourceError
from img_recog.camera.synthetic import SyntheticSource, draw_frame


def opened(name, folders=('',), **settings):
    return open_source(CameraSettings(video_device=str(name), **settings), folders)


def save_still(path, number):
    path.parent.mkdir(exist_ok=True)
    assert cv2.imwrite(str(path), smooth_image(number))


def shows(source, number):
    return np.array_equal(source.read(), smooth_image(number)[..., ::-1])


def test_synthetic_has_the_size_and_rate_of_the_settings():
    source = opened('synthetic', image_width=320, image_height=240, framerate=12)
    assert isinstance(source, SyntheticSource)
    assert (source.width, source.height, source.rate_hz) == (320, 240, 12.0)
    assert np.array_equal(source.read(), draw_frame(0, 320, 240))


def test_synthetic_is_not_looked_for_among_files(tmp_path, monkeypatch):
    save_still(tmp_path / 'still.png', 0)
    (tmp_path / 'still.png').rename(tmp_path / 'synthetic')
    monkeypatch.chdir(tmp_path)
    assert isinstance(opened('synthetic'), SyntheticSource)


def test_auto_without_a_device_is_synthetic(tmp_path, monkeypatch):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', str(tmp_path / 'video0'))
    assert isinstance(opened('auto'), SyntheticSource)


def test_auto_with_a_device_is_that_device(tmp_path, monkeypatch):
    save_still(tmp_path / 'video0.png', 3)
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', str(tmp_path / 'video0.png'))
    source = opened('auto')
    assert isinstance(source, StillSource) and shows(source, 3)


def test_auto_with_a_device_that_is_no_camera_is_refused_and_not_replaced(monkeypatch):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', '/dev/null')
    with pytest.raises(SourceError, match='^cannot open /dev/null: no V4L2 capture device'):
        opened('auto')


def test_character_device_is_opened_with_the_other_settings(monkeypatch):
    given = []
    monkeypatch.setattr(selection, 'DeviceSource', given.append)
    opened('null', folders=('/dev',), image_width=320)
    assert given == [CameraSettings(video_device='/dev/null', image_width=320)]


def test_film_and_still_are_told_apart(make_film, tmp_path):
    save_still(tmp_path / 'still.png', 0)
    film, still = opened(make_film()), opened(tmp_path / 'still.png', framerate=5)
    assert isinstance(film, FilmSource) and isinstance(still, StillSource)
    assert (film.rate_hz, still.rate_hz) == (12.5, 5.0)
    film.close()


def test_content_decides_and_not_the_name(tmp_path):
    save_still(tmp_path / 'still.png', 2)
    (tmp_path / 'still.png').rename(tmp_path / 'still.mp4')
    source = opened(tmp_path / 'still.mp4')
    assert isinstance(source, StillSource) and shows(source, 2)


def test_relative_path_is_looked_for_in_the_folders_in_order(tmp_path):
    first, second = str(tmp_path / 'first'), str(tmp_path / 'second')
    save_still(tmp_path / 'first' / 'only_first.png', 1)
    save_still(tmp_path / 'first' / 'both.png', 2)
    save_still(tmp_path / 'second' / 'both.png', 3)
    save_still(tmp_path / 'second' / 'only_second.png', 4)
    assert shows(opened('only_first.png', (first, second)), 1)
    assert shows(opened('only_second.png', (first, second)), 4)
    assert shows(opened('both.png', (first, second)), 2)
    assert shows(opened('both.png', (second, first)), 3)


def test_relative_path_in_no_folder_names_the_first_place(tmp_path):
    folders = (str(tmp_path / 'first'), str(tmp_path / 'second'))
    with pytest.raises(SourceError) as refused:
        opened('film.mp4', folders)
    assert str(refused.value).startswith(
        'cannot open {}/first/film.mp4: no such file or device'.format(tmp_path))


def test_default_folder_is_the_current_one_and_the_path_becomes_absolute(tmp_path, monkeypatch):
    save_still(tmp_path / 'still.png', 5)
    monkeypatch.chdir(tmp_path)
    source = opened('still.png')
    assert shows(source, 5)
    assert source.description.startswith('still image {}/still.png,'.format(tmp_path))


def test_absolute_path_does_not_depend_on_the_folders(tmp_path):
    save_still(tmp_path / 'still.png', 1)
    save_still(tmp_path / 'folder' / 'still.png', 2)
    assert shows(opened(tmp_path / 'still.png', (str(tmp_path / 'folder'),)), 1)


def test_tilde_is_the_home_folder_whatever_the_folders(tmp_path, monkeypatch):
    save_still(tmp_path / 'home' / 'still.png', 4)
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    assert shows(opened('~/still.png', (str(tmp_path),)), 4)
