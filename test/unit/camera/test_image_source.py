"""JPEG files by their markers, and folders of images."""
import os

import cv2
import numpy as np
import pytest

from img_recog.camera.image_source import image_paths, is_truncated
from img_recog.camera.source import SourceError
from img_recog.camera.video_source import VideoSource

START, END, SCAN = b'\xff\xd8', b'\xff\xd9', b'\xff\xda\x00\x04ab'
SEGMENT = b'\xff\xe0\x00\x06data'


@pytest.mark.parametrize('content, truncated', [
    (START + SEGMENT + SCAN + b'image' + END, False),
    (START + SEGMENT + SCAN + b'image' + END + b'more', False),
    (START + SEGMENT + SCAN + b'image', True),
    (START + SEGMENT + SCAN, True),
    (START + SEGMENT, True),
    (START + SEGMENT + b'\xff', True),
    (START + SCAN + END, False),
    (START + b'\xff\xe0\x00\x02' + SCAN + END, False),          # an empty segment
    (START + b'\xff\xe0\x00\x02' + SCAN, True),
    (START + b'\xff\xe0\x00\x01' + SCAN, False),                # damaged: no length
    (START + b'\xff\xe0\x01\x02' + bytes(256) + SCAN, True),    # a length of two bytes
    (START + b'\xff\xff\xff\xe0\x00\x02' + SCAN, True),         # fill bytes
    (START + b'\xff\xff\xff\xff' + SCAN[1:] + END, False),
    (START + SEGMENT + b'xx\x00\x02' + SCAN, False),            # damaged: no marker
    (START + b'\xff\xe1\x00\x06' + START + END + SCAN, True),   # a thumbnail
    (b'\xff\xd8', False), (b'\x89PNG', False), (b'', False), (b'\xfe\xd8\xff', False)])
def test_jpeg_without_its_end_is_truncated(tmp_path, content, truncated):
    path = tmp_path / 'a.jpg'
    path.write_bytes(content)
    assert is_truncated(str(path)) is truncated


@pytest.mark.parametrize('extension', [
    'bmp', 'jpeg', 'jpg', 'pbm', 'pgm', 'png', 'pnm', 'ppm', 'tif', 'tiff', 'webp', 'PNG'])
def test_extensions_of_images(tmp_path, extension):
    for name in ('b.', 'a.', '.hidden.', 'c'):
        (tmp_path / (name + extension)).write_text('')
    (tmp_path / ('d.' + extension)).mkdir()
    assert [os.path.basename(path) for path in image_paths(str(tmp_path))] == [
        'a.' + extension, 'b.' + extension]


def test_folder_that_cannot_be_read():
    with pytest.raises(SourceError, match='^cannot read /no/such: no such file or directory$'):
        image_paths('/no/such')


class FakeCapture:
    """A video of `count` frames that claims to have `stated`."""

    def __init__(self, stated, count):
        self._stated, self._left = stated, count

    def get(self, number):
        # CAP_PROP_FPS, CAP_PROP_FRAME_COUNT, and the size
        return {5: 25.0, 7: self._stated}.get(number, 2.0)

    def read(self):
        self._left -= 1
        return self._left >= 0, np.zeros((2, 2, 3), np.uint8)

    def release(self):
        pass


@pytest.mark.parametrize('stated, count, complete', [
    (4, 4, True), (4, 2, True), (4, 1, False), (200, 196, True), (200, 195, False),
    (100, 98, True), (100, 97, False), (0, 3, True), (-1, 3, True), (3, 9, True)])
def test_a_few_frames_may_be_missing_at_the_end_of_a_video(monkeypatch, stated, count, complete):
    monkeypatch.setattr(cv2, 'VideoCapture', lambda *_: FakeCapture(stated, count))
    warnings = []
    source = VideoSource('a.avi', warn=warnings.append)
    assert source.expected_frames == max(0, stated) and source.rate_hz == source.expected_hz == 25
    for _ in range(2 * count + 1):
        source.read()
    assert warnings == ([] if complete else [
        'the video a.avi breaks off after {} of {} frames: truncated or damaged'.format(
            count, stated)])
