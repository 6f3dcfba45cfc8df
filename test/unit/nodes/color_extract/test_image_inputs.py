"""Raw images are processed when they arrive; the loop gets the newest while that is too slow."""
import pytest
from sensor_msgs.msg import Image

from img_recog.nodes.color_extract import color_extract_node
from img_recog.nodes.color_extract.color_extract_node import RecognitionDiagnostics


class FakeSubscriber:
    """Takes the place of an ImageSubscriber."""

    def __init__(self, topic, receive, refuse):
        self.topic, self.receive, self.refuse = topic, receive, refuse


class Node:
    """A node with raw images of at most 12 pixels, which takes `seconds` for each.

    now_s: its time; is_free: whether it can process an image; processed: those that it has.
    """

    def __init__(self, monkeypatch):
        made = []
        monkeypatch.setattr(color_extract_node, 'ImageSubscriber',
                            lambda *words: made.append(FakeSubscriber(*words)) or made[0])
        self.now_s, self.seconds, self.is_free, self.processed = 100.0, 0.0, True, []
        self.counts = RecognitionDiagnostics('/image')
        self.input = color_extract_node.ImageInput('/image', 'raw', self.counts, 12, self.process,
                                                   lambda: self.now_s)
        self.subscriber, = made
        self.receive = self.subscriber.receive

    def process(self, msg):
        """Process an image, unless something else is processed."""
        if self.is_free:
            self.processed.append(msg)
            self.input.done(self.seconds)
        return self.is_free


@pytest.fixture
def node(monkeypatch):
    return Node(monkeypatch)


def images(count):
    return [Image(height=number) for number in range(count)]


def test_what_the_subscriber_refuses_is_counted(node):
    assert node.subscriber.topic == '/image'
    node.subscriber.refuse('no image')
    assert (node.counts.refused.total, node.counts.refused.last_reason) == (1, 'no image')


def test_an_image_is_processed_when_it_arrives(node):
    sent = images(5)
    for msg in sent:
        node.receive(msg)
    assert node.processed == sent and node.input.take(0) is None
    assert (node.counts.received.total, node.counts.replaced.total) == (5, 0)


def test_an_image_that_cannot_be_processed_is_left_to_the_loop(node):
    first, second = images(2)
    node.is_free = False
    node.receive(first)
    assert node.processed == [] and node.input.take(0) is first
    node.is_free = True
    node.receive(second)
    assert node.processed == [second] and node.input.take(0) is None
    assert (node.counts.received.total, node.counts.replaced.total) == (2, 0)


def test_after_slow_work_the_loop_gets_the_newest_image_for_a_second(node):
    node.seconds = 0.031
    sent = images(6)
    node.receive(sent[0])
    assert node.processed == sent[:1]
    for msg in sent[1:4]:
        node.now_s += 0.03
        node.receive(msg)
    assert node.processed == sent[:1] and node.input.take(0) is sent[3]
    assert node.counts.replaced.total == 2
    # an image was replaced at 100.09
    node.now_s = 101.08
    node.receive(sent[4])
    assert node.input.take(0) is sent[4]
    node.now_s, node.seconds = 101.1, 0.03
    for msg in sent[5:] * 2:
        node.receive(msg)
    assert node.processed == [sent[0], sent[5], sent[5]] and node.input.take(0) is None


def test_slow_work_of_the_loop_keeps_the_images_there(node):
    for msg in images(5):
        node.input.done(0.2)
        node.now_s += 0.9
        node.receive(msg)
        assert node.input.take(0) is msg
    assert node.processed == []


@pytest.mark.parametrize('waiting, is_left', [(None, False), (1, False), (2, True), (9, True)])
def test_images_that_wait_in_the_socket_are_left_to_the_loop(node, waiting, is_left):
    msg, = images(1)
    if waiting is not None:
        msg = type('Received', (Image,), {'waiting': waiting})()
    node.receive(msg)
    assert (node.input.take(0) is msg, node.processed == [msg]) == (is_left, not is_left)
