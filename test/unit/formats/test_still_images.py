"""Images with too many pixels are refused by their headers, before memory is allocated."""
import os
import subprocess
import sys
import textwrap

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CompressedImage, Image

from img_recog.camera.image_source import FolderSource, read_image
from img_recog.camera.selection import open_file, open_source
from img_recog.camera.source import FrameSkipped, SourceError
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.camera.video_source import VideoSource
from img_recog.conversions import image_msgs
from img_recog.conversions.compressed_image_msgs import from_msg
from img_recog.conversions.image_msgs import ImageError
from img_recog.formats import still_images
from img_recog_helpers import bombs
from img_recog_helpers.fake_decoder import FakeDecoder

HEADERS = bombs.headers()
TOO_LARGE = '20000x20000 are 400000000 pixels, more than max_image_pixels = 50000000'
# decodes each file in the ways of all programs; prints the refusals and the growth in MB
CHILD = '''
import resource, sys
from img_recog.camera.selection import open_source
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.conversions.compressed_image_msgs import from_msg
from img_recog.errors import UserError
from sensor_msgs.msg import CompressedImage

def peak_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024

before = peak_mb()
for path in sys.argv[1:]:
    for decode in (lambda: from_msg(CompressedImage(data=open(path, 'rb').read())),
                   lambda: open_source(UsbCamSettings(video_device=path))):
        try:
            decode()
        except UserError as error:
            print(error)
print(peak_mb() - before)
'''


def test_a_bomb_takes_no_memory_in_any_way(tmp_path):
    paths = []
    for name, data in (('bomb.png', bombs.png()), ('bomb.jpg', bombs.jpeg())):
        (tmp_path / name).write_bytes(data)
        paths.append(str(tmp_path / name))
    assert os.path.getsize(paths[0]) < 1000000
    done = subprocess.run([sys.executable, '-c', textwrap.dedent(CHILD), *paths], check=True,
                          stdout=subprocess.PIPE, universal_newlines=True)
    *refusals, growth_mb = done.stdout.splitlines()
    assert int(growth_mb) < 60, done.stdout
    assert len(refusals) == 4 and all(TOO_LARGE in line for line in refusals), done.stdout


def test_a_video_that_states_a_large_size_is_not_decoded(tmp_path):
    path = str(tmp_path / 'video.avi')
    writer = cv2.VideoWriter(path, cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*'MJPG'), 10, (640, 480))
    writer.write(np.zeros((480, 640, 3), np.uint8))
    writer.release()
    with pytest.raises(SourceError, match=r'^cannot play .*video.avi: 640x480 are 307200 pixels, '
                       r'more than max_image_pixels = 307199; set max_image_pixels'):
        open_source(UsbCamSettings(video_device=path, max_image_pixels=307199))
    assert open_source(UsbCamSettings(video_device=path, max_image_pixels=307200)).width == 640


def test_a_video_that_grows_midway_ends(clock):
    decoder = FakeDecoder(clock, [True, True, np.zeros((49, 64, 3), np.uint8)], rate_hz=10.0)
    source = VideoSource('video.avi', max_pixels=64 * 48, decoder=decoder)
    source.read()
    with pytest.raises(SourceError, match='video.avi: 64x49 are 3136 pixels, more than max_image'):
        source.read()


@pytest.mark.parametrize('name', HEADERS)
def test_the_header_of_each_format_is_read(tmp_path, name):
    path = tmp_path / ('image.' + name)
    path.write_bytes(HEADERS[name])
    side = 16383 if name == 'webp' else 20000
    with pytest.raises(SourceError) as refused:
        read_image(str(path))
    assert str(refused.value) == (
        'cannot read {}: {}x{} are {} pixels, more than max_image_pixels = 50000000; set '
        'max_image_pixels to allow it'.format(path, side, side, side * side))
    reason = '{0}x{0} are' if name == 'jpg' else 'it is [A-Z0-9]+, allowed are JPEG and PNG'
    with pytest.raises(ImageError, match=reason.format(side)):
        from_msg(CompressedImage(format='jpeg', data=HEADERS[name]))


@pytest.mark.parametrize('extension', ['.hdr', '.pfm'])
def test_a_format_whose_size_is_not_known_is_refused(tmp_path, extension):
    path = str(tmp_path / ('image' + extension))
    assert cv2.imwrite(path, np.zeros((8, 8, 3), np.float32))
    assert read_image(path) is None
    with pytest.raises(SourceError, match='neither a video|OpenCV does not read'):
        open_file(path, 30.0)
    with open(path, 'rb') as file, pytest.raises(ImageError):
        from_msg(CompressedImage(data=file.read()))


@pytest.mark.parametrize('extension', ['.bmp', '.jp2', '.jpg', '.png', '.pnm', '.tiff', '.webp'])
@pytest.mark.parametrize('shape', [(64, 80, 3), (64, 80)])
def test_the_limit_is_included(tmp_path, extension, shape):
    path, image = str(tmp_path / ('image' + extension)), np.full(shape, 7, np.uint8)
    assert cv2.imwrite(path, image)
    assert read_image(path, 5120).shape == (64, 80, 3)
    with pytest.raises(SourceError, match='80x64 are 5120 pixels'):
        read_image(path, 5119)
    if extension in ('.jpg', '.png'):
        data = cv2.imencode(extension, image)[1].tobytes()
        assert still_images.decode(data, 5120).shape == shape
        with pytest.raises(still_images.ImageTooLarge):
            still_images.decode(data, 5119)


def test_large_images_of_a_folder_are_skipped(tmp_path):
    for name, side in (('1.png', 200), ('2.png', 8), ('3.png', 200), ('4.png', 8)):
        assert cv2.imwrite(str(tmp_path / name), np.zeros((side, side, 3), np.uint8))
    source = FolderSource(str(tmp_path), 30.0, loop=False, max_pixels=100)
    assert (source.width, source.height) == (8, 8)
    for is_good in (False, True, False, True):
        if is_good:
            assert source.read().shape == (8, 8, 3)
        else:
            with pytest.raises(FrameSkipped, match='200x200 are 40000 pixels'):
                source.read()
    with pytest.raises(SourceError, match='4.png: 8x8 are 64 pixels'):
        FolderSource(str(tmp_path), 30.0, max_pixels=10)


def test_synthetic_scene():
    with pytest.raises(SourceError, match='cannot draw the synthetic scene: 4096x4096 are'):
        open_source(UsbCamSettings(video_device='synthetic', image_width=4096,
                                   image_height=4096, max_image_pixels=1 << 20))


def test_opencv_has_the_upper_end_as_its_own_limit(tmp_path):
    # Pillow is deceived here: the second wall has to hold
    path = tmp_path / 'image.pgm'
    path.write_bytes(b'P5 17000 16000 255\n')
    code = ('import img_recog, cv2\ntry:\n    cv2.imread({!r})\nexcept cv2.error as error:\n'
            '    print(error)'.format(str(path)))
    done = subprocess.run([sys.executable, '-c', code], stdout=subprocess.PIPE, check=True,
                          universal_newlines=True)
    assert 'CV_IO_MAX_IMAGE_PIXELS' in done.stdout


MOST = 2 ** 32 - 1


@pytest.mark.parametrize('height, width, step, data', [
    (MOST, MOST, 0, b''), (1, MOST, MOST, b'1'), (MOST, 1, 0, b'1'), (MOST, 1, 1, b'1234'),
    (2, 2, MOST, bytes(100)), (MOST, 0, 0, b''), (0, MOST, 0, b'')])
@pytest.mark.parametrize('encoding', ['bgr8', 'mono8', 'rgba16', 'yuv422', 'bayer_rggb8', '8UC1',
                                      '64FC4', '8UC0', '8UC9999', '8UC-1', ''])
def test_raw_images_are_bounded_by_their_data(height, width, step, data, encoding):
    for is_bigendian in (0, 1):
        msg = Image(height=height, width=width, step=step, data=data, encoding=encoding,
                    is_bigendian=is_bigendian)
        for convert in (image_msgs.from_msg, image_msgs.ColorImages().from_msg):
            with pytest.raises(ImageError, match='cannot convert an image of {}x{}, encoding'
                               .format(width, height)):
                convert(msg)
