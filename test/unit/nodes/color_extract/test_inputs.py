"""Raw images above the limit are refused."""
import pytest
from sensor_msgs.msg import Image

from img_recog.conversions.image_msgs import ImageError
from img_recog.nodes.color_extract import inputs
from img_recog.nodes.color_extract.diagnostics import RecognitionDiagnostics


@pytest.fixture
def made(monkeypatch):
    """What an input with a limit of 12 pixels gives to its subscriber."""
    made = []
    monkeypatch.setattr(inputs, 'ImageSubscriber', lambda *words: made.append(words))
    return made


@pytest.fixture
def counts():
    return RecognitionDiagnostics('/image')


@pytest.fixture
def raw(made, counts):
    return inputs.RawInput('/image', counts, 12)


def image(width, height, encoding='bgr8', size=3):
    return Image(width=width, height=height, encoding=encoding, step=width * size,
                 data=bytes(width * height * size))


@pytest.mark.parametrize('size', [(4, 3), (12, 1), (1, 12)])
def test_an_image_up_to_the_limit_is_decoded(raw, size):
    assert raw.decode(image(*size))[0].shape == (size[1], size[0], 3)


@pytest.mark.parametrize('size', [(13, 1), (1, 13), (70000, 70000)])
def test_an_image_above_the_limit_is_refused(raw, size):
    msg = image(1, 1)
    msg.width, msg.height = size
    with pytest.raises(ImageError, match='{}x{} are {} pixels, more than max_image_pixels = 12'
                       .format(*size, size[0] * size[1])):
        raw.decode(msg)


def test_the_subscriber_reads_every_image_up_to_the_limit_and_counts_the_others(
        raw, made, counts):
    (topic, _, max_bytes, refuse), = made
    assert topic == '/image' and 12 * 8 + 1000 < max_bytes < 2000000
    refuse('too long')
    assert (counts.refused.total, counts.refused.last_reason) == (1, 'too long')
