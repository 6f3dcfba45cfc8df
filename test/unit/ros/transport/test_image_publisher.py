"""Images drawn where they are sent from, byte for byte what rospy sends."""
import io
from types import SimpleNamespace

import numpy as np
import pytest
from rospy.msg import serialize_message
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.ros.transport import image_publisher
from img_recog.ros.transport.image_publisher import ImagePublisher


class Subscriber:
    """A connection that keeps what it is given, as one that is slow to send it."""

    def __init__(self, fails=False):
        self.queue, self.fails, self.closed = [], fails, False

    def write_data(self, data):
        if self.fails:
            raise OSError('broken')
        self.queue.append(data)

    def close(self):
        self.closed = True


@pytest.fixture
def topic(monkeypatch):
    impl = SimpleNamespace(connections=[], seq=0)
    publisher = SimpleNamespace(impl=impl, get_num_connections=lambda: len(impl.connections))
    monkeypatch.setattr(image_publisher.rospy, 'Publisher', lambda *args, **kwargs: publisher)
    return impl


def header(stamp=7):
    msg = Header(frame_id='head_camera')
    msg.stamp.secs = stamp
    return msg


def random_image(seed, shape=(48, 64, 3)):
    return np.random.RandomState(seed).randint(0, 256, shape).astype(np.uint8)


def publish(publisher, image, encoding='bgr8'):
    publisher.publish(image, encoding, header())


@pytest.mark.parametrize('shape, encoding', [
    ((48, 64, 3), 'bgr8'), ((1, 1, 3), 'rgb8'), ((5, 3, 1), 'mono8'), ((480, 640, 3), 'bgr8')])
def test_the_bytes_are_those_of_rospy(topic, shape, encoding):
    subscriber, publisher = Subscriber(), ImagePublisher('/blue_image')
    topic.connections.append(subscriber)
    for seed in (1, 2):
        image = random_image(seed, shape)
        publish(publisher, image, encoding)
        expected = io.BytesIO()
        serialize_message(expected, seed, Image(
            header(), shape[0], shape[1], encoding, 0, shape[1] * shape[2], image.tobytes()))
        assert bytes(subscriber.queue.pop()) == expected.getvalue()


def test_nothing_is_drawn_without_subscribers(topic):
    ImagePublisher('/blue_image').publish_drawn(lambda _: 1 / 0, (4, 4, 3), 'bgr8', header())


def test_an_image_is_drawn_into_the_packet(topic):
    subscriber, image = Subscriber(), random_image(1)
    topic.connections.append(subscriber)
    ImagePublisher('/blue_image').publish_drawn(
        lambda result: np.copyto(result, image), image.shape, 'bgr8', header())
    assert bytes(subscriber.queue[0]).endswith(image.tobytes())


def test_grey_images_and_rows_that_are_apart(topic):
    subscriber, publisher = Subscriber(), ImagePublisher('/blue_image')
    topic.connections.append(subscriber)
    grey, part = random_image(1, (48, 64)), random_image(2, (48, 80, 3))[:, 3:67]
    publish(publisher, grey, 'mono8')
    publish(publisher, part)
    assert bytes(subscriber.queue[0]).endswith(grey.tobytes())
    assert bytes(subscriber.queue[1]).endswith(part.tobytes())


def test_all_subscribers_have_one_packet(topic):
    topic.connections += [Subscriber(), Subscriber()]
    publish(ImagePublisher('/blue_image'), random_image(1))
    first, second = (each.queue[0] for each in topic.connections)
    assert first is second


def test_memory_is_used_again_when_nobody_sends_from_it_any_more(topic):
    subscriber, publisher = Subscriber(), ImagePublisher('/blue_image')
    topic.connections.append(subscriber)
    publish(publisher, random_image(1))
    first = bytes(subscriber.queue[0])
    publish(publisher, random_image(2))
    assert bytes(subscriber.queue[0]) == first          # still waits, and is as it was
    addresses = {id(packet) for packet in subscriber.queue}
    for seed in range(3, 9):
        del subscriber.queue[0]
        publish(publisher, random_image(seed))
        addresses |= {id(packet) for packet in subscriber.queue}
        assert bytes(subscriber.queue[-1]).endswith(random_image(seed).tobytes())
    assert len(addresses) == 2


def test_memory_of_another_size_is_given_back(topic):
    subscriber, publisher = Subscriber(), ImagePublisher('/blue_image')
    topic.connections.append(subscriber)
    for seed, shape in enumerate([(480, 640, 3), (4, 4, 3), (480, 640, 3)]):
        publish(publisher, random_image(seed, shape))
        subscriber.queue.clear()
        assert len(publisher._packets) == 1


def test_a_subscriber_that_is_gone_is_closed_and_others_go_on(topic):
    gone, there = Subscriber(fails=True), Subscriber()
    topic.connections += [gone, there]
    publish(ImagePublisher('/blue_image'), random_image(1))
    assert gone.closed and not there.closed and len(there.queue) == 1
