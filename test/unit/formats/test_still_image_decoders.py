"""Which library decodes a still image: none sees another size than the one that was checked."""
import argparse
import io
import subprocess
import sys

import cv2
import numpy as np
import pytest
from PIL import Image
from sensor_msgs.msg import CompressedImage

from img_recog.camera.image_source import read_image
from img_recog.conversions.compressed_image_msgs import from_msg
from img_recog.conversions.image_msgs import ImageError
from img_recog.formats import still_images
from img_recog_helpers import bombs

RNG = np.random.RandomState(11)
COLOR = RNG.randint(0, 256, (64, 96, 3)).astype(np.uint8)
GREY, BGRA = COLOR[..., 0].copy(), np.dstack([COLOR, COLOR[..., 0]])
WIDE = RNG.randint(0, 65536, (64, 96, 3)).astype(np.uint16)
# reads each file as a file and as a message; prints what is refused
CHILD = '''
import sys
from img_recog.camera.image_source import read_image
from img_recog.conversions.compressed_image_msgs import from_msg
from img_recog.errors import UserError
from sensor_msgs.msg import CompressedImage
for path in sys.argv[1:]:
    print(read_image(path))
    try:
        from_msg(CompressedImage(data=open(path, 'rb').read()))
    except UserError as error:
        print(error)
'''


def by_opencv(image, extension):
    """Return an encoded image; lossless if it is a JPEG 2000."""
    return cv2.imencode(extension, image, [cv2.IMWRITE_JPEG2000_COMPRESSION_X1000, 1000])[1]


def by_pillow(image, kind='TIFF', **options):
    file = io.BytesIO()
    image.save(file, kind, **options)
    return np.frombuffer(file.getvalue(), np.uint8)


PICTURE = Image.fromarray(COLOR)
GOOD = {
    'color tiff': by_opencv(COLOR, '.tiff'), 'grey tiff': by_opencv(GREY, '.tiff'),
    'alpha tiff': by_opencv(BGRA, '.tiff'), 'deep grey tiff': by_opencv(WIDE[..., 0], '.tiff'),
    'big-endian tiff': by_pillow(Image.fromarray(WIDE[..., 0].astype('>u2'))),
    'palette tiff': by_pillow(PICTURE.quantize(16)),
    'lzw': by_pillow(PICTURE, compression='tiff_lzw'),
    'bits': by_pillow(PICTURE.convert('1'), compression='group4'),
    'color jp2': by_opencv(COLOR, '.jp2'), 'grey jp2': by_opencv(GREY, '.jp2'),
    'alpha jp2': by_opencv(BGRA, '.jp2'), 'deep grey jp2': by_opencv(WIDE[..., 0], '.jp2'),
    'codestream': by_pillow(PICTURE, 'JPEG2000', no_jp2=True)}


@pytest.mark.parametrize('data', list(GOOD.values()), ids=list(GOOD))
def test_tiff_and_jpeg_2000_are_read_like_by_opencv(tmp_path, data):
    path = tmp_path / 'image'
    path.write_bytes(data.tobytes())
    expected = cv2.imdecode(data, cv2.IMREAD_COLOR)
    assert expected is not None and np.array_equal(read_image(str(path)), expected)


@pytest.mark.parametrize('orientation, turned', enumerate([
    COLOR, COLOR[:, ::-1], COLOR[::-1, ::-1], COLOR[::-1], np.swapaxes(COLOR, 0, 1),
    np.rot90(COLOR, -1), np.swapaxes(COLOR[::-1, ::-1], 0, 1), np.rot90(COLOR)], start=1))
def test_a_tiff_is_turned_as_its_orientation_says(tmp_path, orientation, turned):
    path = tmp_path / 'image.tiff'
    path.write_bytes(by_pillow(Image.fromarray(np.ascontiguousarray(COLOR[..., ::-1])),
                               tiffinfo={274: orientation}).tobytes())
    assert np.array_equal(read_image(str(path)), turned)


@pytest.mark.parametrize('data, wanted', [
    (by_opencv(WIDE, '.tiff'), WIDE >> 8), (by_opencv(WIDE, '.jp2'), None),
    *((by_pillow(Image.fromarray(np.zeros((8, 8), kind))), None)
      for kind in (np.float32, np.int32))])
def test_deep_colors(tmp_path, data, wanted):
    path = tmp_path / 'image'
    path.write_bytes(data.tobytes())
    read = read_image(str(path))
    assert (read is None) == (wanted is None) and (wanted is None or np.array_equal(read, wanted))


def test_a_tiff_of_two_sizes_is_not_decoded_in_the_other_size(tmp_path):
    path = tmp_path / 'image.tiff'
    path.write_bytes(bombs.tiff_of_two_sizes(160, 160))
    assert read_image(str(path)).shape == (160, 160, 3)
    for first, last in ((160, 10), (10, 160)):
        path.write_bytes(bombs.tiff_of_two_sizes(first, last))
        assert read_image(str(path)) is None


def test_a_decoder_that_returns_another_size_is_refused(tmp_path, monkeypatch):
    path, image = str(tmp_path / 'image.png'), np.zeros((8, 10, 3), np.uint8)
    assert cv2.imwrite(path, image)
    with open(path, 'rb') as file:
        data = file.read()
    for shape, is_good in (((8, 10, 3), True), ((10, 8, 3), True), ((8, 11, 3), False),
                           ((9, 10, 3), False), ((4, 20, 3), False)):
        monkeypatch.setattr(cv2, 'imread', lambda *_: np.zeros(shape, np.uint8))
        monkeypatch.setattr(cv2, 'imdecode', lambda *_: np.zeros(shape, np.uint8))
        for read in (read_image(path), still_images.decode(data, 80)):
            assert (read is not None) == is_good


@pytest.mark.parametrize('extension', ['.bmp', '.jp2', '.pnm', '.tiff', '.webp'])
def test_only_jpeg_and_png_are_decoded_from_messages(extension):
    data = by_opencv(COLOR, extension).tobytes()
    with pytest.raises(ImageError, match=r"of format 'bgr8; jpeg compressed bgr8', \d+ bytes: "
                       'it is (BMP|JPEG2000|PPM|TIFF|WEBP), allowed are JPEG and PNG$'):
        from_msg(CompressedImage(format='bgr8; jpeg compressed bgr8', data=data))


def test_a_jpeg_with_further_images_is_decoded():
    data = by_pillow(PICTURE, 'MPO', save_all=True, append_images=[PICTURE]).tobytes()
    assert Image.open(io.BytesIO(data)).format == 'MPO'
    assert from_msg(CompressedImage(data=data)).shape == COLOR.shape


def test_damaged_images_are_no_lines_of_the_decoders(tmp_path):
    bmp = by_opencv(COLOR, '.bmp').tobytes()
    files = {'lying.jp2': bombs.lying_jp2(), 'cut.jp2': by_opencv(COLOR, '.jp2').tobytes()[:150],
             'two.tiff': bombs.tiff_of_two_sizes(160, 10),
             'cut.tiff': by_opencv(COLOR, '.tiff').tobytes()[:-20],
             'cut.bmp': bmp[:100], 'cut.webp': by_opencv(COLOR, '.webp').tobytes()[:100],
             'large.pgm': b'P5 17000 2500 255\n'}
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    done = subprocess.run(
        [sys.executable, '-c', CHILD, *(str(tmp_path / name) for name in files)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
    assert (done.returncode, done.stderr) == (0, '')
    lines = done.stdout.splitlines()
    assert len(lines) == 2 * len(files) and lines[::2] == ['None'] * len(files), done.stdout
    assert all(line.startswith('cannot decode a compressed image') for line in lines[1::2])


@pytest.mark.parametrize('name', [b'IDAT', b'tEXt', b'fdAT', b'IDAU'])
def test_png_whose_chunk_states_an_enormous_length_is_not_given_to_opencv(
        tmp_path, monkeypatch, name):
    def refuse(*_):
        raise AssertionError('it would allocate 2 GB')
    monkeypatch.setattr(still_images.cv2, 'imdecode', refuse)
    monkeypatch.setattr(still_images.cv2, 'imread', refuse)
    path = tmp_path / 'lying.png'
    path.write_bytes(bombs.lying_png(name))
    assert read_image(str(path)) is None
    with pytest.raises(ImageError, match='no image that OpenCV can read'):
        from_msg(CompressedImage(data=path.read_bytes()))


def test_a_damaged_png_is_refused_without_a_line_of_libpng(tmp_path, capfd):
    noise = np.random.default_rng(1).integers(0, 255, (40, 60, 3), np.uint8)
    data = bytearray(cv2.imencode('.png', noise)[1].tobytes())
    path = tmp_path / 'damaged.png'
    data[-1000] ^= 255
    path.write_bytes(data)
    assert still_images.read(str(path), 1 << 20) is None
    assert still_images.decode(bytes(data), 1 << 20) is None
    assert capfd.readouterr().err == ''


@pytest.mark.parametrize('end', [b'', b'\xff' * 100])
def test_png_of_many_chunks_is_decoded_whatever_follows_its_end(tmp_path, end):
    noise = RNG.randint(0, 256, (200, 300, 3)).astype(np.uint8)
    data = cv2.imencode('.png', noise)[1].tobytes()
    assert data.count(b'IDAT') > 10
    path = tmp_path / 'noise.png'
    path.write_bytes(data + end)
    assert np.array_equal(read_image(str(path)), noise)
    assert np.array_equal(from_msg(CompressedImage(data=path.read_bytes())), noise)


@pytest.mark.parametrize('kind, count', [('GIF', 2), ('TIFF', 2), ('MPO', 1), ('PNG', 1)])
def test_how_many_images_a_file_has(tmp_path, kind, count):
    path = str(tmp_path / 'image')
    images = [Image.fromarray(COLOR // number) for number in (1, 2)]
    images[0].save(path, kind, save_all=kind != 'PNG', append_images=images[1:])
    assert still_images.count(path) == count
    (tmp_path / 'image').write_text('text')
    assert still_images.count(path) == 1


@pytest.mark.parametrize('words, pixels', [([], 50000000), (['--max-image-pixels', '7'], 7)])
def test_the_option_of_programs(words, pixels):
    parser = argparse.ArgumentParser()
    still_images.add_option(parser)
    assert parser.parse_args(words).max_image_pixels == pixels
    with pytest.raises(SystemExit):
        parser.parse_args(['--max-image-pixels', '0'])
    with pytest.raises(SystemExit):
        parser.parse_args(['--max-image-pixels', '\u00b2'])
