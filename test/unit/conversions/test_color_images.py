"""Color images of messages of all encodings are bit-identical to those of cv_bridge."""
import cv2
import numpy as np
import pytest
from cv_bridge import CvBridge
from sensor_msgs.msg import Image

from img_recog.conversions.image_msgs import ColorImages, ImageError, from_msg
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.recognition_settings import with_colors

CHANNELS = {'bgr8': 3, 'rgb8': 3, 'bgra8': 4, 'rgba8': 4, 'mono8': 1, 'yuv422': 2,
            'bayer_rggb8': 1, 'bayer_bggr8': 1, 'bayer_gbrg8': 1, 'bayer_grbg8': 1}
BY_CV_BRIDGE = {'mono16': 2, 'rgb16': 6, 'bgra16': 8}
ORDERS = {'bgr8': slice(None), 'bgra8': slice(0, 3), 'rgb8': [2, 1, 0], 'rgba8': [2, 1, 0]}


def message(encoding, bytes_a_pixel, height=48, width=64, padding=0, seed=0):
    size = height, width * bytes_a_pixel
    rows = np.random.RandomState(seed).randint(0, 256, size).astype(np.uint8)
    data = np.pad(rows, ((0, 0), (0, padding)))
    return Image(height=height, width=width, encoding=encoding, step=data.shape[1],
                 data=data.tobytes())


def in_bgr8(image, encoding):
    return image[..., ORDERS[encoding]]


@pytest.mark.parametrize('padding', [0, 14])
@pytest.mark.parametrize('encoding, size', [*CHANNELS.items(), *BY_CV_BRIDGE.items()])
def test_every_encoding_equals_cv_bridge(encoding, size, padding):
    expected = CvBridge().imgmsg_to_cv2(message(encoding, size), 'bgr8')
    padded = message(encoding, size, padding=padding)
    image, order = ColorImages().from_msg(padded)
    assert np.array_equal(in_bgr8(image, order), expected)
    assert np.array_equal(from_msg(padded, 'bgr8'), expected)
    extractor, plain = (ColorExtractor(with_colors()()) for _ in range(2))
    assert extractor.measure(image, order) == plain.measure(np.ascontiguousarray(expected))
    for number in (0, 1):
        assert np.array_equal(extractor.masked(number), plain.masked(number))


def test_yuy2():
    msg = message('yuv422_yuy2', 2)
    pixels = np.frombuffer(msg.data, np.uint8).reshape(48, 64, 2)
    image, order = ColorImages().from_msg(msg)
    assert order == 'bgr8'
    assert np.array_equal(image, cv2.cvtColor(pixels, cv2.COLOR_YUV2BGR_YUY2))


def test_an_odd_width_of_pairs_of_pixels_is_refused():
    with pytest.raises(ImageError, match="encoding 'yuv422'"):
        ColorImages().from_msg(message('yuv422', 2, width=63))


@pytest.mark.parametrize('encoding', ['bgr8', 'rgb8', 'bgra8', 'rgba8'])
def test_color_images_share_the_memory_of_the_message(encoding):
    msg = message(encoding, CHANNELS[encoding], padding=5)
    msg.data = bytearray(msg.data)
    image, order = ColorImages().from_msg(msg)
    assert order == encoding
    assert np.shares_memory(image, np.frombuffer(msg.data, np.uint8))


def test_conversion_reuses_its_buffer():
    images = ColorImages()
    first, _ = images.from_msg(message('mono8', 1))
    second, _ = images.from_msg(message('mono8', 1, seed=1))
    assert np.shares_memory(first, second)
    other, _ = images.from_msg(message('mono8', 1, height=20))
    assert other.shape == (20, 64, 3)


@pytest.mark.parametrize('change, text', [
    ({'width': 0}, 'it has no pixels'), ({'height': 0}, 'it has no pixels'),
    ({'step': 100}, 'a row takes 192 bytes'), ({'data': b'short'}, 'the data is too short'),
    ({'data': bytes(192 * 48 - 1)}, 'the data is too short'),
    ({'data': b''}, 'the data is too short'), ({'data': b''}, ', 0 bytes to bgr8'),
    ({'height': 4000000000}, 'the data is too short'), ({'encoding': 'rgb9'}, "'rgb9'"),
    ({'width': 1 << 20, 'height': 1 << 20}, 'a row takes'),
    ({'encoding': ''}, "encoding ''"), ({'encoding': '32FC1', 'step': 256}, '32FC1')])
@pytest.mark.parametrize('convert', [ColorImages().from_msg, lambda msg: from_msg(msg, 'bgr8')])
def test_invalid_message_is_refused(convert, change, text):
    msg = message('rgb8', 3)
    for name, value in change.items():
        setattr(msg, name, value)
    with pytest.raises(ImageError) as caught:
        convert(msg)
    assert text in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.parametrize('encoding, channel_bytes, words', [
    ('8UC1', 1, "; publish it with encoding='mono8': "),
    ('8UC3', 3, "; publish it with encoding='bgr8': "),
    ('8UC4', 4, "; publish it with encoding='bgra8': "),
    ('16UC1', 2, "; an image of depth has none; if it is another one, publish it with "
     "encoding='mono16': "),
    ('32FC1', 4, '; an image of depth has none; '),
    ('16SC3', 6, "; publish it with encoding='bgr8': ")])
@pytest.mark.parametrize('wanted, convert', [
    ('bgr8', ColorImages().from_msg), ('mono8', lambda msg: from_msg(msg, 'mono8'))])
def test_an_encoding_without_colors_is_refused_with_the_one_to_use(
        encoding, channel_bytes, words, wanted, convert):
    msg = Image(height=2, width=2, encoding=encoding, step=2 * channel_bytes,
                data=bytes(4 * channel_bytes))
    with pytest.raises(ImageError) as caught:
        convert(msg)
    assert str(caught.value).startswith(
        'cannot convert an image of 2x2 to {}: encoding {} does not say which colors it has{}'
        .format(wanted, encoding, words))


@pytest.mark.parametrize('size', [(4, 3), (12, 1), (1, 12)])
def test_an_image_up_to_the_limit_is_converted(size):
    assert ColorImages(12).from_msg(message('bgr8', 3, *size))[0].shape == size + (3,)


@pytest.mark.parametrize('width, height', [(13, 1), (1, 13), (70000, 70000)])
def test_an_image_above_the_limit_is_refused(width, height):
    msg = message('bgr8', 3, 1, 1)
    msg.width, msg.height = width, height
    with pytest.raises(ImageError, match='{}x{} are {} pixels, more than max_image_pixels = 12'
                       .format(width, height, width * height)):
        ColorImages(12).from_msg(msg)
