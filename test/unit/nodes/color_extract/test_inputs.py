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
    return inputs.RawInput('/image', counts, 12, lambda msg: (), lambda msg: True)


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
    (topic, _, max_bytes, refuse, _), = made
    assert topic == '/image' and 12 * 8 + 1000 < max_bytes < 2000000
    refuse('too long')
    assert (counts.refused.total, counts.refused.last_reason) == (1, 'too long')


class Work:
    """What a node does with raw images: counts them, and takes `seconds` for each."""

    def __init__(self):
        self.processed, self.begun, self.seconds, self.is_free = [], [], 0.0, True

    def begin(self, msg):
        """Take note of an image that is not complete."""
        self.begun.append(msg)
        return [1, 2]

    def process(self, msg):
        """Process an image, unless something else is processed."""
        if self.is_free:
            self.processed.append(msg)
            self.input.took(self.seconds)
        return self.is_free


@pytest.fixture
def clock():
    """The time of an input, in a list."""
    return [100.0]


@pytest.fixture
def work(made, counts, clock):
    """The work of a node whose input gets images by `arrive`."""
    work = Work()
    work.input = inputs.RawInput('/image', counts, 12, work.begin, work.process, lambda: clock[0])
    (_, store, _, _, begin), = made

    def arrive(msg):
        work.steps = list(begin(msg))
        store(msg)
    work.arrive = arrive
    return work


@pytest.fixture
def released(monkeypatch, made):
    """The messages whose memory is released."""
    released = []
    monkeypatch.setattr(inputs.RawInput, 'done', lambda _, msg: released.append(msg))
    return released


def test_an_image_is_processed_when_it_arrives(work, counts):
    images = [image(1, 1) for _ in range(5)]
    for msg in images:
        work.arrive(msg)
        assert work.steps == [1, 2]
    assert work.begun == work.processed == images and work.input.take(0) is None
    assert (counts.received.total, counts.replaced.total) == (5, 0)


def test_an_image_is_left_to_the_loop_while_something_is_processed(work, counts):
    first, second = image(1, 1), image(1, 1)
    work.is_free = False
    work.arrive(first)
    assert work.processed == [] and work.input.take(0) is first
    work.is_free = True
    work.arrive(second)
    assert work.processed == [second] and work.input.take(0) is None
    assert (counts.received.total, counts.replaced.total) == (2, 0)


def test_after_slow_work_the_loop_gets_the_newest_image_for_a_second(work, counts, clock,
                                                                     released):
    work.seconds = 0.031
    images = [image(1, 1) for _ in range(6)]
    work.arrive(images[0])
    assert work.processed == images[:1]
    for msg in images[1:4]:
        clock[0] += 0.03
        work.arrive(msg)
        assert work.steps == []
    assert work.processed == images[:1] and work.input.take(0) is images[3]
    assert counts.replaced.total == 2 and released == images[1:3]
    # an image was replaced at 100.09
    clock[0] = 101.08
    work.arrive(images[4])
    assert work.steps == [] and work.input.take(0) is images[4]
    clock[0], work.seconds = 101.1, 0.03
    for msg in images[5:] * 2:
        work.arrive(msg)
        assert work.steps == [1, 2]
    assert work.processed == [images[0], images[5], images[5]] and work.input.take(0) is None


def test_slow_work_of_the_loop_keeps_the_images_there(work, clock):
    work.input.took(0.2)
    for _ in range(5):
        clock[0] += 0.9
        msg = image(1, 1)
        work.arrive(msg)
        assert work.input.take(0) is msg
        work.input.took(0.2)
    assert work.processed == []


@pytest.mark.parametrize('waiting, is_left', [(0, False), (1, False), (2, True), (9, True)])
def test_images_that_wait_in_the_socket_are_left_to_the_loop(work, monkeypatch, waiting, is_left):
    monkeypatch.setattr(inputs.image_subscriber, 'backlog', lambda msg: waiting)
    msg = image(1, 1)
    work.arrive(msg)
    assert (work.input.take(0) is msg, work.processed == [msg]) == (is_left, not is_left)


def test_what_need_not_be_decoded_can_be_seen_before_it_is_complete(raw):
    for encoding, channels in (('bgr8', 3), ('rgb8', 3), ('bgra8', 4), ('rgba8', 4)):
        assert raw.view(image(4, 3, encoding, channels)).shape == (3, 4, channels)
    assert raw.view(image(4, 3, 'mono8', 1)) is None
    with pytest.raises(ImageError, match='13x1 are 13 pixels'):
        raw.view(image(13, 1))
    with pytest.raises(ImageError, match='a row takes 16 bytes'):
        raw.view(image(4, 3, 'bgra8', 3))
