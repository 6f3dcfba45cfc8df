"""Files that cannot be a frame source: each is refused with one line that names it."""
import os
import socket
import subprocess
import sys

import cv2
import pytest

from img_recog.camera.image_source import UNREADABLE
from img_recog.camera.selection import open_file, open_source
from img_recog.camera.source import SourceError
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog_helpers import bombs, refusals
from img_recog_helpers.videos import smooth_image

NOT_PLAYABLE = ('cannot play {}: neither a video nor an image that OpenCV reads; give one, '
                'or synthetic')


def refusal(path):
    with pytest.raises(SourceError) as refused:
        open_source(UsbCamSettings(video_device=str(path)))
    assert '\n' not in str(refused.value)
    return str(refused.value)


@pytest.fixture
def devices(monkeypatch):
    found = []
    monkeypatch.setattr('img_recog.camera.device_source.glob.glob', {'/dev/video*': found}.get)
    return found


ADVICE = ('give a device, a video, an image, synthetic or auto: camera:=synthetic to ./run demo '
          'and roslaunch, _video_device:=synthetic to rosrun')


@pytest.mark.parametrize('found, listed', [((), 'there is no /dev/video*'),
                                           ('31', 'there are /dev/video1, /dev/video3')])
def test_missing_device_lists_the_devices_and_says_where_to_set_one(devices, found, listed):
    devices[:] = map('/dev/video{}'.format, found)
    assert refusal('/dev/video77') == (
        'cannot open /dev/video77: no such device ({}); {}'.format(listed, ADVICE))


def test_missing_file_says_nothing_about_devices(tmp_path, devices):
    path = tmp_path / 'missing.mp4'
    path.symlink_to(tmp_path / 'gone.mp4')
    assert refusal(path) == 'cannot open {}: no such file; {}'.format(path, ADVICE)


@pytest.mark.parametrize('name, content', [
    ('text.mp4', b'this is a text\n' * 50),
    ('text.png', b'this is a text\n' * 50),
    ('text.txt', b'this is a text\n' * 50),
    ('text.nfo', 'words of several bytes: \u9752\n'.encode() * 400),
    ('empty.mp4', b''),
    ('empty.png', b''),
    ('zeros.avi', bytes(5000)),
    ('sizeless.png', bombs.png(0, 0)),
    ('cut.png', bombs.png(8, 8)[:30])])
def test_file_that_is_neither_a_video_nor_an_image(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    # of the last two, the first bytes are those of an image
    words = UNREADABLE if content.startswith(b'\x89PNG') else NOT_PLAYABLE
    assert refusal(path) == words.format(path)


@pytest.mark.parametrize('fourcc, name, kept', [
    ('MJPG', 'video.avi', 1000), ('mp4v', 'video.mp4', 1000), ('mp4v', 'video.mp4', 0.5)])
def test_truncated_video(make_video, fourcc, name, kept):
    path = make_video(name, fourcc)
    size = os.path.getsize(path)
    os.truncate(path, kept if kept > 1 else int(kept * size))
    assert os.path.getsize(path) < size
    assert refusal(path) == NOT_PLAYABLE.format(path)


def with_codec_qqqq(make_video):
    path = make_video('other.avi', 'MJPG')
    with open(path, 'r+b') as file:
        data = file.read().replace(b'MJPG', b'qqqq')
        file.seek(0)
        file.write(data)
    return path


def test_codec_without_a_decoder_is_named(make_video):
    path = with_codec_qqqq(make_video)
    assert refusal(path) == (
        'cannot play {}: FFmpeg decodes no frame of it (codec qqqq): it has no decoder for that, '
        'or the file is damaged; convert it: ffmpeg -i INPUT -c:v libx264 OUTPUT.mp4'.format(path))


# the log levels are read when the libraries are loaded
QUIET = '''
import sys
from img_recog.camera import selection, source, usb_cam_settings
for name in sys.argv[1:]:
    try:
        selection.open_source(usb_cam_settings.UsbCamSettings(video_device=name))
    except source.SourceError as error:
        print(error)
'''


def test_the_libraries_print_nothing(make_video):
    cut, other = make_video('cut.mp4', 'mp4v'), with_codec_qqqq(make_video)
    os.truncate(cut, 1000)
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))         # so that no other program listens there
        urls = ['{}://127.0.0.1:{}/live'.format(scheme, free.getsockname()[1])
                for scheme in ('http', 'rtsp', 'rtmp')]
        done = subprocess.run([sys.executable, '-c', QUIET, *urls, cut, other],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True)
    assert (done.returncode, done.stderr) == (0, '')
    assert len(done.stdout.splitlines()) == 5


@pytest.mark.parametrize('kept', [20, 0.5, -2])
def test_truncated_jpeg(tmp_path, capfd, kept):
    path, data = tmp_path / 'still.jpg', cv2.imencode('.jpg', smooth_image(0))[1]
    path.write_bytes(data.tobytes()[:int(kept * len(data)) if isinstance(kept, float) else kept])
    assert refusal(path) == UNREADABLE.format(path)
    assert capfd.readouterr().err == ''


@pytest.mark.parametrize('extra', [b'', b'and more', bytes(9000)])
@pytest.mark.parametrize('progressive', [0, 1])
def test_jpeg_with_data_after_its_end_is_read(tmp_path, extra, progressive):
    path = tmp_path / 'still.jpg'
    flags = [cv2.IMWRITE_JPEG_PROGRESSIVE, progressive]
    path.write_bytes(cv2.imencode('.jpg', smooth_image(0), flags)[1].tobytes() + extra)
    assert open_file(str(path), 30.0).read().shape == (64, 96, 3)


@pytest.mark.parametrize('make, what', [
    (os.mkdir, 'there is no image in it that can be read; give a folder with '
     'images'),
    (os.mkfifo, 'neither a device nor a file; give one')])
def test_what_is_no_file(tmp_path, make, what):
    make(str(tmp_path / 'path'))
    assert refusal(tmp_path / 'path') == (
        'cannot open {}: {}, or synthetic'.format(
            tmp_path / 'path', what))


def test_character_device_that_is_not_a_camera(devices):
    devices.append('/dev/video7')
    assert refusal('/dev/null') == (
        'cannot open /dev/null: no V4L2 capture device, or in use by another program (there '
        'is /dev/video7); give one of these, a file, or synthetic')


def test_file_without_permission_to_read(make_video, monkeypatch):
    path = make_video()
    monkeypatch.setattr(os, 'access', lambda path, mode: mode != os.R_OK)
    assert refusals.refusal(open_file, path, 30.0) == (
        'cannot read {}: permission denied'.format(path))
