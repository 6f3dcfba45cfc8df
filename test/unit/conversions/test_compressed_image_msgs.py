"""Arrays to sensor_msgs/CompressedImage and back: formats, colors, lossless PNG, errors."""
import cv2
import numpy as np
import pytest
from cv_bridge import CvBridge
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from img_recog.conversions.compressed_image_msgs import CompressionSettings, from_msg, to_msg
from img_recog.conversions.image_msgs import ImageError

RNG = np.random.RandomState(5)
NOISE = RNG.randint(0, 256, (30, 40, 3)).astype(np.uint8)
GREY = RNG.randint(0, 256, (30, 40)).astype(np.uint8)
PNG = CompressionSettings(format='png')
BLUE = np.full((32, 32, 3), (200, 60, 20), np.uint8)      # bgr8


def by_cv_bridge(msg, encoding='passthrough'):
    return CvBridge().compressed_imgmsg_to_cv2(msg, encoding)


@pytest.mark.parametrize('image, encoding, jpeg, png', [
    (NOISE, 'rgb8', 'rgb8; jpeg compressed bgr8', 'rgb8; png compressed bgr8'),
    (NOISE, 'bgr8', 'bgr8; jpeg compressed bgr8', 'bgr8; png compressed bgr8'),
    (GREY, 'mono8', 'mono8; jpeg compressed ', 'mono8; png compressed ')])
def test_format_and_header_are_those_of_compressed_image_transport(image, encoding, jpeg, png):
    header = Header(frame_id='camera', seq=7)
    for settings, text, magic in ((CompressionSettings(), jpeg, b'\xff\xd8\xff'),
                                  (PNG, png, b'\x89PNG')):
        msg = to_msg(image, encoding, header, settings)
        assert (msg.format, msg.header) == (text, header)
        assert msg.data.startswith(magic)


ALPHA = np.dstack([NOISE, GREY])
WIDE = NOISE.astype(np.uint16) * 257


@pytest.mark.parametrize('image, encoding, jpeg, png', [
    (ALPHA, 'bgra8', 'bgr8', 'bgr8'), (ALPHA[..., [2, 1, 0, 3]], 'rgba8', 'bgr8', 'bgr8'),
    (WIDE, 'bgr16', 'bgr8', 'bgr16'), (WIDE[..., ::-1], 'rgb16', 'bgr8', 'bgr16'),
    (WIDE[..., 0], 'mono16', '', ''), (WIDE[..., 0], '16UC1', '', ''), (GREY, '8UC1', '', ''),
    (GREY, 'bayer_gbrg8', '', ''), (WIDE[..., 0], 'bayer_rggb16', '', ''),
    (NOISE, '8UC3', '', ''), (ALPHA, '8UC4', '', '')])
def test_other_encodings_are_compressed_as_by_the_plugin(image, encoding, jpeg, png):
    image = np.ascontiguousarray(image)
    msg = to_msg(image, encoding, Header(), PNG)
    assert msg.format == '{}; png compressed {}'.format(encoding, png)
    wanted = CvBridge().cv2_to_imgmsg(image, encoding)
    wanted = CvBridge().imgmsg_to_cv2(wanted, png or 'passthrough')
    assert np.array_equal(cv2.imdecode(np.frombuffer(msg.data, np.uint8), -1), wanted)
    msg = to_msg(image, encoding, Header())
    assert msg.format == '{}; jpeg compressed {}'.format(encoding, jpeg)
    assert msg.data.startswith(b'\xff\xd8\xff')


def test_another_format_is_an_error_that_names_those_there_are():
    with pytest.raises(ImageError, match='as gif: the format has to be one of jpeg, png$'):
        to_msg(NOISE, 'bgr8', Header(), CompressionSettings(format='gif'))


def test_png_is_lossless():
    for image, encoding, bgr in ((NOISE, 'bgr8', NOISE), (NOISE[..., ::-1], 'rgb8', NOISE)):
        msg = to_msg(np.ascontiguousarray(image), encoding, Header(), PNG)
        assert np.array_equal(from_msg(msg), bgr)
        assert np.array_equal(by_cv_bridge(msg), bgr)
        assert np.array_equal(by_cv_bridge(msg, 'bgr8'), bgr)
        assert np.array_equal(by_cv_bridge(msg, 'rgb8'), bgr[..., ::-1])


@pytest.mark.parametrize('level', [1, 9])
def test_grey_png_is_lossless(level):
    msg = to_msg(GREY, 'mono8', Header(), CompressionSettings(format='png', png_level=level))
    assert np.array_equal(by_cv_bridge(msg), GREY)
    assert np.array_equal(from_msg(msg), cv2.cvtColor(GREY, cv2.COLOR_GRAY2BGR))


def test_jpeg_keeps_the_order_of_colors():
    for image, encoding in ((BLUE, 'bgr8'), (BLUE[..., ::-1], 'rgb8')):
        msg = to_msg(np.ascontiguousarray(image), encoding, Header())
        for read in (from_msg(msg), by_cv_bridge(msg, 'bgr8')):
            assert np.abs(read.astype(int) - BLUE).max() <= 3


def test_jpeg_quality_and_options_are_used():
    def size(**settings):
        return len(to_msg(NOISE, 'bgr8', Header(), CompressionSettings(**settings)).data)
    assert size(jpeg_quality=10) < size() < size(jpeg_quality=100)
    assert size(jpeg_optimize=True) < size() < size(jpeg_restart_interval=1)
    progressive = to_msg(NOISE, 'bgr8', Header(), CompressionSettings(jpeg_progressive=True))
    assert b'\xff\xc2' in progressive.data


def png_of(image, text):
    return CompressedImage(format=text, data=cv2.imencode('.png', image)[1].tobytes())


FROM_OTHERS = {
    'no details': (png_of(NOISE, 'png'), NOISE),
    'no format': (png_of(NOISE, ''), NOISE),
    'grey without details': (png_of(GREY, 'png'), cv2.cvtColor(GREY, cv2.COLOR_GRAY2BGR)),
    'old publisher': (png_of(NOISE, 'bgr8; png compressed rgb8'), NOISE[..., ::-1]),
    'alpha': (png_of(np.dstack([NOISE, GREY]), 'rgba8; png compressed bgr8'), NOISE),
    'sixteen bits': (png_of(WIDE, 'rgb16; png compressed bgr16'), NOISE),
    'bayer': (png_of(GREY, 'bayer_rggb8; png compressed '),
              cv2.cvtColor(GREY, cv2.COLOR_BayerBG2BGR)),
    'jpeg of ROS 2': (png_of(GREY, 'mono8; png compressed mono8'),
                      cv2.cvtColor(GREY, cv2.COLOR_GRAY2BGR)),
}


@pytest.mark.parametrize('msg, bgr', list(FROM_OTHERS.values()), ids=list(FROM_OTHERS))
def test_messages_of_other_publishers(msg, bgr):
    assert np.array_equal(from_msg(msg), bgr)


@pytest.mark.parametrize('data', [b'', b'no image', b'\x89PNG\r\n\x1a\n',
                                  to_msg(NOISE, 'bgr8', Header()).data[:100]],
                         ids=['empty', 'text', 'png header', 'jpeg header'])
def test_error_of_data_that_cannot_be_decoded_is_one_line(data):
    with pytest.raises(ImageError) as error:
        from_msg(CompressedImage(format='rgb8; jpeg compressed bgr8', data=data))
    assert "format 'rgb8; jpeg compressed bgr8', {} bytes".format(len(data)) in str(error.value)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize('image, encoding', [
    (NOISE, 'mono8'), (GREY, 'rgb8'), (GREY, 'bgr8'), (NOISE[..., :2], 'bgr8'),
    (NOISE, 'bayer_rggb8'), (NOISE, ''), (WIDE, 'rgb8'),
    (GREY, 'mono16'), (GREY.astype(np.float32), '32FC1'), (NOISE[..., :2], 'yuv422'),
    (NOISE[..., :2], '8UC2'), (NOISE[:0], 'bgr8')])
@pytest.mark.parametrize('settings', [CompressionSettings(), PNG], ids=['jpeg', 'png'])
def test_error_of_an_image_that_cannot_be_compressed_is_one_line(image, encoding, settings):
    with pytest.raises(ImageError, match=r'encoding {!r} as {}'.format(
            encoding, settings.format)) as error:
        to_msg(image, encoding, Header(), settings)
    assert '\n' not in str(error.value)


def test_an_encoder_that_fails_without_an_error_is_an_error(monkeypatch):
    monkeypatch.setattr(cv2, 'imencode', lambda *_: (False, None))
    with pytest.raises(ImageError, match='as jpeg: the encoder failed'):
        to_msg(GREY, 'mono8', Header())


def test_a_long_encoding_is_shortened_in_the_error():
    with pytest.raises(ImageError, match='^cannot compress an image of shape') as refused:
        to_msg(NOISE, 'x\n' * 1000, Header())
    assert len(str(refused.value)) < 800 and '\n' not in str(refused.value)
    msg = png_of(GREY, 'bayer_{}; png compressed '.format('x\n' * 1000))
    with pytest.raises(ImageError, match='^cannot decode a compressed image') as refused:
        from_msg(msg)
    assert len(str(refused.value)) < 800 and '\n' not in str(refused.value)
