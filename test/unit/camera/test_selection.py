"""The frame source that video_device names."""
import os

import cv2
import numpy as np
import pytest

from img_recog.camera import selection
from img_recog.camera.image_source import FolderSource, ImageSource
from img_recog.camera.selection import open_source
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError
from img_recog.camera.synthetic import BLUE_FRAMES, SyntheticSource, draw_frame
from img_recog.camera.video_source import VideoSource
from img_recog_testing.videos import smooth_image


def opened(name, folders=('',), **settings):
    return open_source(CameraSettings(video_device=str(name), **settings), folders)


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


def test_auto_without_a_device_is_synthetic(tmp_path, monkeypatch):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', str(tmp_path / 'video0'))
    assert isinstance(opened('auto'), SyntheticSource)


def test_auto_with_a_device_is_that_device(tmp_path, monkeypatch):
    save_image(tmp_path / 'video0.png', 3)
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', str(tmp_path / 'video0.png'))
    source = opened('auto')
    assert isinstance(source, ImageSource) and shows(source, 3)


def test_auto_with_a_device_that_is_not_a_camera_is_refused(monkeypatch):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', '/dev/null')
    with pytest.raises(SourceError, match='^cannot open /dev/null: no V4L2 capture device'):
        opened('auto')


def test_character_device_is_opened_with_the_other_settings(monkeypatch):
    given = []
    monkeypatch.setattr(selection, 'DeviceSource', given.append)
    opened('null', folders=('/dev',), image_width=320)
    assert given == [CameraSettings(video_device='/dev/null', image_width=320)]


def test_video_and_image_are_distinguished(make_video, tmp_path):
    save_image(tmp_path / 'still.png', 0)
    video, still = opened(make_video()), opened(tmp_path / 'still.png', framerate=5)
    assert isinstance(video, VideoSource) and isinstance(still, ImageSource)
    assert (video.rate_hz, still.rate_hz) == (12.5, 5.0)
    video.close()


def test_file_type_is_that_of_the_content(tmp_path):
    save_image(tmp_path / 'still.png', 2)
    (tmp_path / 'still.png').rename(tmp_path / 'still.mp4')
    source = opened(tmp_path / 'still.mp4')
    assert isinstance(source, ImageSource) and shows(source, 2)


def test_relative_path_is_searched_for_in_the_folders_in_order(tmp_path):
    first, second = str(tmp_path / 'first'), str(tmp_path / 'second')
    save_image(tmp_path / 'first' / 'only_first.png', 1)
    save_image(tmp_path / 'first' / 'both.png', 2)
    save_image(tmp_path / 'second' / 'both.png', 3)
    save_image(tmp_path / 'second' / 'only_second.png', 4)
    assert shows(opened('only_first.png', (first, second)), 1)
    assert shows(opened('only_second.png', (first, second)), 4)
    assert shows(opened('both.png', (first, second)), 2)
    assert shows(opened('both.png', (second, first)), 3)


def test_error_of_a_relative_path_names_the_first_folder(tmp_path):
    folders = (str(tmp_path / 'first'), str(tmp_path / 'second'))
    with pytest.raises(SourceError) as refused:
        opened('video.mp4', folders)
    assert str(refused.value).startswith(
        'cannot open {}/first/video.mp4: no such file or device'.format(tmp_path))


def test_default_folder_is_the_current_one_and_the_path_becomes_absolute(tmp_path, monkeypatch):
    save_image(tmp_path / 'still.png', 5)
    monkeypatch.chdir(tmp_path)
    source = opened('still.png')
    assert shows(source, 5)
    assert source.description.startswith('image {}/still.png,'.format(tmp_path))


def test_absolute_path_does_not_depend_on_the_folders(tmp_path):
    save_image(tmp_path / 'still.png', 1)
    save_image(tmp_path / 'folder' / 'still.png', 2)
    assert shows(opened(tmp_path / 'still.png', (str(tmp_path / 'folder'),)), 1)


def test_tilde_is_the_home_folder(tmp_path, monkeypatch):
    save_image(tmp_path / 'home' / 'still.png', 4)
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    assert shows(opened('~/still.png', (str(tmp_path),)), 4)


def test_folder_of_images_is_played_by_name_at_the_framerate(tmp_path):
    for name, number in (('b.png', 1), ('a.png', 0), ('c.PNG', 2)):
        save_image(tmp_path / name.lower(), number)
        (tmp_path / name.lower()).rename(tmp_path / name)
    (tmp_path / 'notes.txt').write_text('no image')
    (tmp_path / '.hidden.png').write_bytes((tmp_path / 'a.png').read_bytes())
    (tmp_path / 'd.png').mkdir()
    source = opened(tmp_path, framerate=5)
    assert isinstance(source, FolderSource) and source.rate_hz == 5.0
    assert source.description == 'folder {} of 3 images, 96x64, 5 Hz, played in a loop'.format(
        tmp_path)
    for number in (0, 1, 2, 0, 1, 2, 0):
        assert shows(source, number)


def test_folder_without_loop_ends(tmp_path):
    save_image(tmp_path / 'a.png', 0)
    save_image(tmp_path / 'b.png', 1)
    source = opened(tmp_path, loop=False)
    assert shows(source, 0) and shows(source, 1)
    with pytest.raises(SourceEnded, match='^the folder .* has ended after 2 images$'):
        source.read()


def test_images_of_another_size_in_a_folder_are_skipped(tmp_path):
    save_image(tmp_path / 'a.png', 0)
    assert cv2.imwrite(str(tmp_path / 'b.png'), smooth_image(1, 80, 48))
    (tmp_path / 'c.png').write_bytes((tmp_path / 'a.png').read_bytes()[:60])
    save_image(tmp_path / 'd.png', 3)
    source = opened(tmp_path)
    assert shows(source, 0)
    with pytest.raises(FrameSkipped, match='b.png is 80x48 in a folder of 96x64'):
        source.read()
    with pytest.raises(FrameSkipped, match='^cannot read the image .*c.png$'):
        source.read()
    assert shows(source, 3) and shows(source, 0)


def test_folder_that_is_emptied_ends(tmp_path):
    save_image(tmp_path / 'a.png', 0)
    source = opened(tmp_path)
    assert shows(source, 0)
    (tmp_path / 'a.png').unlink()
    with pytest.raises(FrameSkipped):
        source.read()
    with pytest.raises(SourceError, match='can no longer be read: emptied'):
        source.read()


def test_video_without_loop_ends_after_its_last_frame(make_video):
    path = make_video()
    source = opened(path, loop=False)
    assert source.description.endswith('12.5 Hz, played once')
    for _ in range(6):
        source.read()
    with pytest.raises(SourceEnded) as ended:
        source.read()
    assert str(ended.value) == 'the video {} has ended after 6 frames'.format(path)
    source.close()


def write_truncated_jpeg(path, thumbnail=False):
    """Write a truncated JPEG; optionally after a thumbnail, which has its own end."""
    good, data = cv2.imencode('.jpg', smooth_image(4))
    data = data.tobytes()
    if thumbnail:
        application = b'Exif\0\0' + data
        data = (data[:2] + b'\xff\xe1' + (len(application) + 2).to_bytes(2, 'big') + application
                + data[2:])
    assert good and data.endswith(b'\xff\xd9')
    path.write_bytes(data[:-len(data) // 4])


@pytest.mark.parametrize('thumbnail', [False, True])
def test_truncated_jpeg_is_skipped_in_a_folder(tmp_path, thumbnail):
    save_image(tmp_path / 'a.png', 0)
    write_truncated_jpeg(tmp_path / 'b.jpg', thumbnail)
    save_image(tmp_path / 'c.png', 2)
    source = opened(tmp_path)
    assert shows(source, 0)
    with pytest.raises(FrameSkipped, match='^cannot read the image .*b.jpg$'):
        source.read()
    assert shows(source, 2)


@pytest.mark.parametrize('loop', [True, False])
def test_truncated_video_is_one_warning(make_video, loop):
    path, warnings = make_video(frames=60), []
    size = os.path.getsize(path)
    os.truncate(path, size // 2)
    source = open_source(CameraSettings(video_device=path, loop=loop), warn=warnings.append)
    count = 0
    try:
        while count < 100:
            source.read()
            count += 1
    except SourceEnded:
        assert not loop and 10 < count < 50
    assert len(warnings) == 1
    assert warnings[0].startswith('the video {} breaks off after '.format(path))
    assert warnings[0].endswith(' of 60 frames: truncated or damaged')
    source.close()


def test_complete_video_has_no_warning(make_video):
    warnings = []
    source = open_source(CameraSettings(video_device=make_video()), warn=warnings.append)
    for _ in range(20):
        source.read()
    source.close()
    assert warnings == []


def test_auto_is_resolved_once(tmp_path, monkeypatch):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', str(tmp_path))
    settings = selection.resolve_auto(CameraSettings(video_device='auto'))
    assert settings.video_device == str(tmp_path)
    assert selection.resolve_auto(settings) is settings


def test_other_url_is_refused_with_the_known_schemes():
    with pytest.raises(SourceError, match='^cannot open gopher://x: .* http://, https://, rtmp'):
        opened('gopher://me@x')


@pytest.mark.parametrize('content, is_text', [
    (b'', False), (b'a', True), (b' ', True), (b'\x1f', False), (b'\t\n\f\r\x1b', True),
    (b'\x0b', False), (b'\xff', True), (b'a\0', False), (b'a' * 4095 + b'\0', False),
    (b'a' * 4096 + b'\0', True)])
def test_text_has_no_control_characters_at_its_start(tmp_path, content, is_text):
    (tmp_path / 'file').write_bytes(content)
    assert selection._is_text(str(tmp_path / 'file')) is is_text


def test_pipe_in_the_place_of_a_device_is_refused_with_advice(tmp_path):
    os.mkfifo(str(tmp_path / 'pipe'))
    with pytest.raises(SourceError) as refused:
        opened(tmp_path / 'pipe')
    assert refused.value.problem.endswith('pipe: neither a device nor a file')
    assert refused.value.advice == 'set video_device to one, or to synthetic'
