"""Recordings by names, folders and patterns: what opens by itself is found in a folder."""
import errno
import os
import shutil
import subprocess

import cv2
import numpy as np
import pytest
import rosbag
from std_msgs.msg import String

from img_recog.errors import UserError
from img_recog.recordings.recording_names import expand, is_bag
from img_recog_helpers.refusals import refusal

RAW = 'h264', 'hevc', 'm4v', 'mjpeg'       # films without a container
FILMS = ('3gp', 'asf', 'avi', 'f4v', 'flv', 'gif', 'm2ts', 'mkv', 'mov', 'mp4', 'mpg', 'mts',
         'mxf', 'nut', 'ogv', 'ts', 'vob', 'webm', 'wmv', 'y4m') + RAW
PICTURES = 'bmp', 'jp2', 'jpg', 'png', 'ppm', 'ras', 'sr', 'tiff', 'webp'


@pytest.fixture(scope='module')
def films(tmp_path_factory):
    """A folder with a short film of each kind, named by its kind."""
    folder = tmp_path_factory.mktemp('films')
    # 352x288 at 25 Hz: of all containers, some take only a few sizes and rates
    subprocess.check_call([
        'ffmpeg', '-loglevel', 'error', '-f', 'lavfi', '-i', 'testsrc=size=352x288:rate=25',
        *(word for kind in FILMS for word in [
            '-frames:v', '5', *(['-pix_fmt', 'yuv420p'] if kind == 'y4m' else []),
            str(folder / ('film.' + kind))])])
    return folder


def found_in(folder, *left_out):
    lines = []
    paths = expand([str(folder)], lines.append)
    assert lines == (['{} of {} entries of the folder {} left out: {}'.format(
        len(left_out), len(left_out) + len(paths), folder, ', '.join(left_out))]
        if left_out else [])
    return [os.path.basename(path) for path in paths]


def test_films_of_all_kinds_in_a_folder_are_found(films):
    assert found_in(films) == sorted('film.' + kind for kind in FILMS)


def test_films_are_found_by_their_content_too(films, tmp_path):
    for kind in FILMS:
        if kind not in RAW:
            shutil.copy(str(films / ('film.' + kind)), str(tmp_path / (kind + '_film')))
    assert len(found_in(tmp_path)) == len(FILMS) - len(RAW)


def test_pictures_of_all_kinds_in_a_folder_are_found(tmp_path):
    for kind in PICTURES:
        assert cv2.imwrite(str(tmp_path / ('a.' + kind)), np.zeros((64, 64, 3), np.uint8))
    assert found_in(tmp_path) == sorted('a.' + kind for kind in PICTURES)


def test_what_is_left_out_of_a_folder_is_said(tmp_path):
    with rosbag.Bag(str(tmp_path / 'a.bag'), 'w') as bag:
        bag.write('/chatter', String('x'))
    shutil.copy(str(tmp_path / 'a.bag'), str(tmp_path / 'bag_without_a_name'))
    (tmp_path / 'broken.mp4').write_bytes(b'x')     # named as what cannot be read, later
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'main.ts').write_text('export default 1;')
    (tmp_path / 'noise').write_bytes(bytes(range(256)) * 9)
    (tmp_path / 'notes.txt').write_text('x')
    (tmp_path / '.hidden.txt').write_text('x')
    os.mkfifo(str(tmp_path / 'pipe.mp4'))
    assert found_in(tmp_path, 'folder', 'main.ts', 'noise', 'notes.txt', 'pipe.mp4') == [
        'a.bag', 'bag_without_a_name', 'broken.mp4']


@pytest.mark.parametrize('name, reason', [
    ('no', 'no such file'), ('*.no', 'no such file'), ('empty', 'there is no recording in it'),
    ('pipe', 'it is not a file')])
def test_a_name_that_means_no_recording_is_refused(tmp_path, name, reason):
    (tmp_path / 'empty').mkdir()
    os.mkfifo(str(tmp_path / 'pipe'))
    assert refusal(expand, [str(tmp_path / name)]).startswith(
        'cannot read {}: {}; '.format(tmp_path / name, reason))


def test_a_recording_that_may_not_be_read(tmp_path, monkeypatch):
    def denied(path, mode):
        raise PermissionError(errno.EACCES, 'Permission denied', path)
    path = tmp_path / 'a.bag'
    path.write_bytes(b'')
    monkeypatch.setattr('builtins.open', denied)        # root may read each file
    with pytest.raises(UserError, match='^cannot read {}: permission denied; see its permissions '
                       .format(path)):
        is_bag(str(path))
