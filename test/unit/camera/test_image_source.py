"""JPEG files by their markers, and folders of images."""
import os

import pytest

from img_recog.camera.image_source import image_paths, is_truncated
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
