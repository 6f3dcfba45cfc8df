"""Arrays to sensor_msgs/Image and back, of either endianness; more is in test_color_images.py."""
import numpy as np
import pytest
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.conversions.image_msgs import ImageError, from_msg, to_msg

RNG = np.random.RandomState(3)
COLOR = RNG.randint(0, 256, (6, 8, 3)).astype(np.uint8)
GREY = RNG.randint(0, 256, (6, 8)).astype(np.uint8)


def message(image, encoding, padding=0, **fields):
    rows = np.ascontiguousarray(image).reshape(len(image), -1).view(np.uint8)
    data = np.full((len(rows), rows.shape[1] + padding), 255, np.uint8)
    data[:, :rows.shape[1]] = rows
    return Image(height=image.shape[0], width=image.shape[1], encoding=encoding,
                 step=data.shape[1], data=data.tobytes(), **fields)


@pytest.mark.parametrize('image, encoding', [(COLOR, 'bgr8'), (COLOR, 'rgb8'), (GREY, 'mono8')])
def test_round_trip(image, encoding):
    header = Header(frame_id='camera', seq=7)
    msg = to_msg(image, encoding, header)
    assert (msg.header, msg.encoding, msg.width, msg.height) == (header, encoding, 8, 6)
    assert msg.step == image[0].nbytes
    assert np.array_equal(from_msg(msg, encoding), image)


@pytest.mark.parametrize('padding', [0, 6])
def test_sixteen_bits_of_either_endianness(padding):
    wide = RNG.randint(0, 65536, (6, 8)).astype(np.uint16)
    for order, big in (('<u2', 0), ('>u2', 1)):
        msg = message(wide.astype(order), 'mono16', padding, is_bigendian=big)
        assert np.array_equal(from_msg(msg, 'mono16'), wide)


def test_bytes_have_no_endianness():
    assert np.array_equal(from_msg(message(COLOR, 'bgr8', is_bigendian=1), 'bgr8'), COLOR)


def test_array_that_does_not_match_the_encoding():
    with pytest.raises(ImageError, match='as mono8'):
        to_msg(COLOR, 'mono8', Header())


def test_a_long_encoding_is_shortened_in_the_error():
    with pytest.raises(ImageError, match='^cannot publish an image of shape') as refused:
        to_msg(COLOR, 'x\n' * 1000, Header())
    assert len(str(refused.value)) < 500 and '\n' not in str(refused.value)
