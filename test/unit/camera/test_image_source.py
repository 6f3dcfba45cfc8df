"""JPEG files by their markers, and folders of images."""
import os

import cv2
import numpy as np
import pytest

from img_recog.camera.image_source import files_in, is_image, is_truncated
from img_recog.camera.source import SourceError

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
    'bmp', 'j2k', 'jp2', 'jpeg', 'jpg', 'pbm', 'pgm', 'png', 'pnm', 'ppm', 'ras', 'sr', 'tif',
    'tiff', 'webp', 'PNG'])
def test_extensions_of_images(tmp_path, extension):
    for name in ('b.', 'a.', '.hidden.', 'c'):
        (tmp_path / (name + extension)).write_text('')
    (tmp_path / ('d.' + extension)).mkdir()
    found, left_out = files_in(str(tmp_path), is_image)
    assert [os.path.basename(path) for path in found] == ['a.' + extension, 'b.' + extension]
    assert left_out == '2 of 4 entries of the folder {} left out: c{}, d.{}'.format(
        tmp_path, extension, extension)


def test_folder_that_cannot_be_read():
    with pytest.raises(SourceError, match='^cannot read /no/such: no such file or directory$'):
        files_in('/no/such', is_image)


PNG = cv2.imencode('.png', np.zeros((4, 4), np.uint8))[1].tobytes()


@pytest.mark.parametrize('name, make, is_there', [
    ('name', lambda path: path.write_bytes(PNG), True),         # by its content
    ('a.png', lambda path: os.mkfifo(str(path)), False),        # is not opened
    # a format that OpenCV has switched off
    ('a.exr', lambda path: path.write_bytes(b'\x76\x2f\x31\x01' + bytes(99)), False)])
def test_what_is_an_image_in_a_folder(tmp_path, name, make, is_there):
    make(tmp_path / name)
    assert files_in(str(tmp_path), is_image) == (
        ([str(tmp_path / name)], '') if is_there else
        ([], '1 of 1 entries of the folder {} left out: {}'.format(tmp_path, name)))
