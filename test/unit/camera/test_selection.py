"""The frame source that video_device names."""
import os
import re

import cv2
import numpy as np
import pytest

from img_recog.camera import selection, video_source
from img_recog.camera.image_source import FolderSource, ImageSource
from img_recog.camera.selection import open_source
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError
from img_recog.camera.synthetic import BLUE_FRAMES, SyntheticSource, draw_frame
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.camera.video_source import VideoSource
from img_recog_helpers.videos import smooth_image


def opened(name, folders=('',), **settings):
    return open_source(UsbCamSettings(video_device=str(name), **settings), folders)


def save_image(path, number):
    path.parent.mkdir(exist_ok=True)
    assert cv2.imwrite(str(path), smooth_image(number))


def shows(source, number):
    return np.array_equal(source.read(), smooth_image(number)[..., ::-1])


def test_synthetic_has_the_size_and_rate_of_the_settings():
    source = opened('synthetic', image_width=320, image_height=240, framerate=12)
    assert isinstance(source, SyntheticSource)
    assert (source.width, source.height, source.rate_hz) == (320, 240, 12.0)
    assert np.array_equal(source.read(), draw_frame(BLUE_FRAMES.start, 320, 240))


def test_synthetic_is_not_searched_for_as_a_file(tmp_path, monkeypatch):
    save_image(tmp_path / 'still.png', 0)
    (tmp_path / 'still.png').rename(tmp_path / 'synthetic')
    monkeypatch.chdir(tmp_path)
    assert isinstance(opened('synthetic'), SyntheticSource)


def test_auto_is_resolved_once(tmp_path, monkeypatch):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', str(tmp_path / 'video0.png'))
    assert isinstance(opened('auto'), SyntheticSource)
    save_image(tmp_path / 'video0.png', 3)
    assert shows(opened('auto'), 3)
    settings = selection.resolve_auto(UsbCamSettings(video_device='auto'))
    assert settings.video_device == str(tmp_path / 'video0.png')
    assert selection.resolve_auto(settings) is settings
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', '/dev/null')
    with pytest.raises(SourceError, match='^cannot open /dev/null: no V4L2 capture device'):
        opened('auto')


def test_character_device_is_opened_with_the_other_settings(monkeypatch):
    given = []
    monkeypatch.setattr(selection, 'DeviceSource', given.append)
    opened('null', folders=('/dev',), image_width=320)
    assert given == [UsbCamSettings(video_device='/dev/null', image_width=320)]


def test_video_and_image_are_distinguished_by_their_content(make_video, tmp_path):
    save_image(tmp_path / 'still.png', 2)
    (tmp_path / 'still.png').rename(tmp_path / 'still.mp4')
    video, still = opened(make_video()), opened(tmp_path / 'still.mp4', framerate=5)
    assert isinstance(video, VideoSource) and isinstance(still, ImageSource) and shows(still, 2)
    assert (video.rate_hz, still.rate_hz) == (12.5, 5.0)
    video.close()


@pytest.mark.parametrize('name, folders, number', [
    ('here.png', ('',), 0), ('one.png', ('first', 'second'), 1),
    ('both.png', ('first', 'second'), 2), ('both.png', ('second', 'first'), 3),
    ('two.png', ('first', 'second'), 4), ('~/both.png', ('first',), 3), ('/here.png', ('',), 0),
    ('/here.png', ('first',), 0)])
def test_path_is_searched_for_in_the_folders_in_order(tmp_path, monkeypatch, name, folders,
                                                      number):
    for path, shown in (('here.png', 0), ('first/one.png', 1), ('first/both.png', 2),
                        ('second/both.png', 3), ('second/two.png', 4), ('first/here.png', 5)):
        save_image(tmp_path / path, shown)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', str(tmp_path / 'second'))
    source = opened(name.replace('/h', '{}/h'.format(tmp_path)), folders)
    assert shows(source, number) and source.description.startswith('image {}/'.format(tmp_path))


def test_error_of_a_relative_path_names_the_first_folder(tmp_path):
    folders = (str(tmp_path / 'first'), str(tmp_path / 'second'))
    with pytest.raises(SourceError, match='^cannot open {}/first/video.mp4: no such file;'
                       .format(tmp_path)):
        opened('video.mp4', folders)


def test_folder_of_images_is_played_by_name_at_the_framerate(tmp_path):
    for name, number in (('b.png', 1), ('a.png', 0), ('c.bmp', 2)):
        save_image(tmp_path / name, number)
    (tmp_path / 'notes.txt').write_text('no image')
    source = opened(tmp_path, framerate=5)
    assert isinstance(source, FolderSource) and source.name == str(tmp_path)
    assert source.rate_hz == source.expected_hz == 5.0
    assert source.description == 'folder {} of 3 images, 96x64, 5 Hz, played in a loop'.format(
        tmp_path)
    for number in (0, 1, 2):
        assert shows(source, number)
    with pytest.raises(SourceEnded, match='has ended after 3 images$'):
        source.read()
    assert source.loops


def test_what_is_left_out_of_a_folder_is_said(tmp_path):
    lines = []
    save_image(tmp_path / 'a.png', 0)
    settings = UsbCamSettings(video_device=str(tmp_path))
    open_source(settings, warn=lines.append)
    assert lines == []
    (tmp_path / 'film.mp4').write_bytes(b'x')
    (tmp_path / 'more').mkdir()
    open_source(settings, warn=lines.append)
    assert lines == ['2 of 3 entries of the folder {} left out: film.mp4, more'.format(tmp_path)]


@pytest.mark.parametrize('is_video', [False, True])
def test_what_is_played_once_ends(tmp_path, make_video, is_video):
    for number in range(0 if is_video else 6):
        save_image(tmp_path / '{}.png'.format(number), number)
    path = make_video() if is_video else str(tmp_path)
    source = opened(path, loop=False)
    assert source.description == '{}, 96x64, {}'.format(
        *(('video ' + path, '12.5 Hz, played once') if is_video
          else ('folder {} of 6 images'.format(path), '30 Hz, played once')))
    for _ in range(6):
        assert source.read().shape == (64, 96, 3)
    with pytest.raises(SourceEnded, match='^the {} has ended after 6 {}$'.format(
            *(('video ' + path, 'frames') if is_video else ('folder ' + path, 'images')))):
        source.read()
    source.close()


def test_images_of_another_size_and_truncated_ones_in_a_folder_are_skipped(tmp_path):
    save_image(tmp_path / 'a.png', 0)
    assert cv2.imwrite(str(tmp_path / 'b.png'), smooth_image(1, 80, 48))
    (tmp_path / '0.png').write_bytes((tmp_path / 'a.png').read_bytes()[:60])
    (tmp_path / 'd.jpg').write_bytes(cv2.imencode('.jpg', smooth_image(4))[1].tobytes()[:-200])
    save_image(tmp_path / 'e.png', 3)
    source = opened(tmp_path)
    unreadable = '^cannot read the image .*{}: it is damaged, or'.format
    for wanted in (unreadable('0.png'), 0, 'b.png is 80x48 in a folder of 96x64',
                   unreadable('d.jpg'), 3):
        if isinstance(wanted, int):
            assert shows(source, wanted)
        else:
            with pytest.raises(FrameSkipped, match=wanted):
                source.read()


def test_truncated_video_is_one_warning(make_video):
    path, lines = make_video(frames=60), []
    os.truncate(path, os.path.getsize(path) // 2)
    source = open_source(UsbCamSettings(video_device=path), warn=lines.append)
    with pytest.raises(SourceEnded):
        while True:
            source.read()
    source.close()
    line, = lines
    assert re.match('the video {} breaks off after [1-4]. of 60 frames: truncated or damaged$'
                    .format(path), line)


def test_other_url_is_refused_with_the_known_schemes():
    with pytest.raises(SourceError, match='^cannot open gopher://x: .* http://, https://, rtmp'):
        opened('gopher://me@x')


@pytest.mark.parametrize('content, is_text', [
    (b'', False), (b'a', True), (b' ', True), (b'\x1f', False), (b'\t\n\f\r\x1b', True),
    (b'\x0b', False), (b'\xff', True), (b'a\0', False), (b'a' * 4095 + b'\0', False),
    (b'a' * 4096 + b'\0', True)])
def test_text_has_no_control_characters_at_its_start(tmp_path, monkeypatch, content, is_text):
    monkeypatch.setattr(video_source, 'VideoSource', lambda *_: 'a video')
    (tmp_path / 'file').write_bytes(content)
    if is_text:
        with pytest.raises(SourceError, match='neither a video nor an image that OpenCV reads'):
            opened(tmp_path / 'file')
    else:
        assert opened(tmp_path / 'file') == 'a video'
