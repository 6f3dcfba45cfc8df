"""Images through real connections of rospy."""
import queue
import threading

import numpy as np
import pytest
import rospy
from sensor_msgs.msg import Image

from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog_helpers.tcpros import packet
from img_recog_helpers.waiting import DEADLINE_S, wait_for


def image(seed, height=48, width=64, encoding='rgb8', frame_id='camera'):
    data = np.random.RandomState(seed).randint(0, 256, height * width * 3).astype(np.uint8)
    msg = Image(height=height, width=width, encoding=encoding, step=3 * width,
                data=data.tobytes())
    msg.header.seq, msg.header.frame_id = seed, frame_id
    msg.header.stamp.secs, msg.header.stamp.nsecs = 1000 + seed, 5
    return msg


class Receiver:
    """An ImageSubscriber that puts its images in a queue."""

    def __init__(self, name):
        self._images = queue.Queue()
        ImageSubscriber(name, self._images.put)

    def receive(self):
        """Return the next image."""
        return self._images.get(timeout=DEADLINE_S)

    def is_idle(self):
        """Return whether the queue is empty."""
        return self._images.empty()


@pytest.fixture
def receiver(name):
    return Receiver(name)


def assert_equal(got, sent):
    assert bytes(got.data) == sent.data
    for name in ('header', 'height', 'width', 'encoding', 'is_bigendian', 'step'):
        assert getattr(got, name) == getattr(sent, name)


def test_images_of_many_sizes_one_after_the_other(way, name, receiver, publish_to):
    publisher = publish_to(name, Image)
    for number, size in enumerate(
            [(480, 640), (1, 1), (1080, 1920), (0, 0), (48, 64), (480, 640)]):
        sent = image(number, *size)
        publisher.send(sent)
        got = receiver.receive()
        assert_equal(got, sent)


def test_strings_of_any_length(way, name, receiver, publish_to):
    publisher = publish_to(name, Image)
    for number, (encoding, frame_id) in enumerate([('', ''), ('x' * 1000, 'ä/' * 500)]):
        sent = image(number, encoding=encoding, frame_id=frame_id)
        publisher.send(sent)
        assert_equal(receiver.receive(), sent)


def test_images_have_the_header_of_the_connection(way, name, receiver, publish_to):
    publish_to(name, Image).send(image(1))
    assert receiver.receive()._connection_header == {'callerid': '/publisher'}


def test_two_publishers(way, name, receiver, publish_to):
    for number in range(2):
        publisher = publish_to(name, Image)
        publisher.send(image(number))
        assert_equal(receiver.receive(), image(number))
    assert len(publisher.topic.connections) == 2


def test_an_error_in_the_callback_does_not_end_the_connection(way, name, publish_to, monkeypatch):
    lines, images = [], queue.Queue()
    monkeypatch.setattr(rospy.topics, 'logerr', lines.append)

    def call(msg):
        images.put(msg)
        raise ZeroDivisionError
    ImageSubscriber(name, call)
    publisher = publish_to(name, Image)
    for number in range(2):
        publisher.send(image(number))
        assert_equal(images.get(timeout=DEADLINE_S), image(number))
    wait_for(lambda: len(lines) == 2 and all('bad callback' in line for line in lines),
             lambda: lines)
    assert len(publisher.topic.connections) == 1


def test_a_connection_from_before_the_subscription(fast, name, publish_to):
    rospy.Subscriber(name, Image)
    publisher = publish_to(name, Image)
    receiver = Receiver(name)
    publisher.send(image(1))
    assert_equal(receiver.receive(), image(1))


# Only the fast transport: plain rospy may drop some of these messages, which arrive at once.

def test_data_that_was_read_with_the_handshake_is_used(fast, name, receiver, publish_to):
    sent = [image(1), image(2), image(3)]
    data = b''.join(map(packet, sent))
    publisher = publish_to(name, Image, begin=False)
    publisher.transport.read_buff.write(data[:5000])
    publisher.begin()
    publisher.send_bytes(data[5000:])
    for msg in sent:
        assert_equal(receiver.receive(), msg)


def test_small_images_that_were_read_with_the_handshake(fast, name, receiver, publish_to):
    publisher = publish_to(name, Image, begin=False)
    publisher.transport.protocol.queue_size = None
    publisher.transport.read_buff.write(packet(image(1, 1, 1)) + packet(image(2, 2, 2)))
    publisher.begin()
    assert_equal(receiver.receive(), image(1, 1, 1))
    assert_equal(receiver.receive(), image(2, 2, 2))
    publisher.send(image(3))
    assert_equal(receiver.receive(), image(3))


def test_the_images_that_wait_in_the_socket_are_counted(fast, name, publish_to):
    counts, may_go_on = queue.Queue(), threading.Event()

    def handle(msg):
        counts.put((msg.waiting, msg.header.seq))
        may_go_on.wait(DEADLINE_S)
    ImageSubscriber(name, handle)
    publisher = publish_to(name, Image)
    publisher.send(image(0))
    assert counts.get(timeout=DEADLINE_S) == (0, 0)
    publisher.sock.sendall(b''.join(packet(image(number)) for number in range(1, 4)))
    may_go_on.set()
    assert [counts.get(timeout=DEADLINE_S) for _ in range(3)] == [(2, 1), (1, 2), (0, 3)]


def test_a_publisher_that_closes_in_the_middle_of_an_image(way, name, receiver, publish_to):
    publisher = publish_to(name, Image)
    publisher.sock.sendall(packet(image(0))[:3000])
    publisher.sock.close()
    publisher.join()
    assert receiver.is_idle() and not publisher.topic.connections


# Other subscribers in the same process

def exchange(publisher, receiver, numbers):
    """Send images one after the other."""
    for number in numbers:
        publisher.send(image(number))
        assert_equal(receiver.receive(), image(number))


@pytest.mark.parametrize('is_first', [True, False])
def test_another_subscriber_in_the_process_may_keep_its_images(way, name, publish_to, is_first):
    kept = queue.Queue()
    receiver = None if is_first else Receiver(name)
    rospy.Subscriber(name, Image, kept.put)
    receiver = receiver or Receiver(name)
    exchange(publish_to(name, Image), receiver, range(10))
    for number in range(10):
        assert_equal(kept.get(timeout=DEADLINE_S), image(number))


def test_another_subscriber_that_is_added_between_two_images(way, name, receiver, publish_to):
    kept = queue.Queue()
    publisher = publish_to(name, Image)
    exchange(publisher, receiver, range(3))
    other = rospy.Subscriber(name, Image, kept.put)
    exchange(publisher, receiver, range(3, 6))
    wait_for(lambda: kept.qsize() == 3, 'the images of the other one')
    other.unregister()
    exchange(publisher, receiver, range(6, 9))
    assert kept.qsize() == 3
    for number in range(3, 6):
        assert_equal(kept.get_nowait(), image(number))


def test_another_subscriber_that_is_added_in_the_callback_of_an_image(fast, name, publish_to):
    kept, done = queue.Queue(), queue.Queue()
    entered, resume = threading.Event(), threading.Event()

    def handle(msg):
        entered.set()
        assert resume.wait(DEADLINE_S)
        done.put(msg)
    ImageSubscriber(name, handle)
    publisher = publish_to(name, Image)
    publisher.send(image(1))
    assert entered.wait(DEADLINE_S)
    rospy.Subscriber(name, Image, kept.put)
    resume.set()
    publisher.send(image(2))
    for _ in range(2):
        done.get(timeout=DEADLINE_S)
    assert_equal(kept.get(timeout=DEADLINE_S), image(2))        # added too late for the first


def test_a_later_subscriber_gets_a_latched_image(way, name, receiver, publish_to):
    publisher = publish_to(name, Image, is_latched=True)
    exchange(publisher, receiver, range(3))
    wait_for(lambda: publisher.transport.latch is not None and
             publisher.transport.latch.header.seq == 2, 'the latch')
    kept = queue.Queue()
    rospy.Subscriber(name, Image, kept.put)
    assert_equal(kept.get(timeout=DEADLINE_S), image(2))


def test_two_image_subscribers_of_one_topic(way, name, publish_to):
    receivers = [Receiver(name), Receiver(name)]
    publisher = publish_to(name, Image)
    held = []
    for number in range(5):
        publisher.send(image(number))
        for receiver in receivers:
            got = receiver.receive()
            assert_equal(got, image(number))
            held.append((got, number))
    for got, number in held:
        assert_equal(got, image(number))
