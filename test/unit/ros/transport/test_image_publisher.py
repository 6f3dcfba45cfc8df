"""Images to real connections of rospy: the same bytes that rospy sends, from reused buffers."""
import io
import os
import warnings

import numpy as np
import pytest
import rospy
from rospy.msg import serialize_message
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from img_recog.ros.transport import outbox
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog_testing.extraction import random_image
from img_recog_testing.waiting import wait_for

LARGE = (480, 640, 3)       # larger than the buffers of a socket pair


def header(stamp=7):
    msg = Header(frame_id='head_camera')
    msg.stamp.secs = stamp
    return msg


def publish(publisher, image, encoding='bgr8'):
    publisher.publish(image, encoding, header())


def wire(image, seq, encoding='bgr8'):
    """Return the bytes that rospy would send."""
    height, width = image.shape[:2]
    buffer = io.BytesIO()
    serialize_message(buffer, seq, Image(
        header(), height, width, encoding, 0, image[0].size, image.tobytes()))
    return buffer.getvalue()


@pytest.fixture
def publisher(name):
    return ImagePublisher(name)


@pytest.mark.parametrize('shape, encoding', [
    ((48, 64, 3), 'bgr8'), ((1, 1, 3), 'rgb8'), ((5, 3, 1), 'mono8'), ((48, 64), 'mono8'), (
        LARGE, 'bgr8')])
def test_the_bytes_equal_those_of_rospy(way, name, publisher, subscribe, shape, encoding):
    subscriber = subscribe(name, Image)
    for seq in (1, 2):
        image = random_image(seq, shape)
        publish(publisher, image, encoding)
        assert subscriber.receive() == wire(image, seq, encoding)


def test_nothing_is_drawn_without_subscribers(way, publisher):
    publisher.publish_drawn(lambda *_: 1 / 0, (4, 4, 3), 'bgr8', header())


def test_a_drawn_image_is_sent(way, name, publisher, subscribe):
    subscriber, image = subscribe(name, Image), random_image(1)
    publisher.publish_drawn(lambda result, _: np.copyto(result, image), image.shape, 'bgr8',
                            header())
    assert subscriber.receive() == wire(image, 1)


def test_an_image_whose_rows_are_not_contiguous(way, name, publisher, subscribe):
    subscriber, part = subscribe(name, Image), random_image(2, (48, 80, 3))[:, 3:67]
    publish(publisher, part)
    assert subscriber.receive() == wire(part, 1)


def test_the_header_is_not_changed(way, name, publisher, subscribe):
    subscribe(name, Image)
    given = header()
    given.seq = 99
    publisher.publish(random_image(1), 'bgr8', given)
    assert given.seq == 99


def test_all_subscribers_get_each_image(way, name, publisher, subscribe):
    ends = [subscribe(name, Image) for _ in range(3)]
    for seq in range(1, 6):
        publish(publisher, random_image(seq, LARGE))
        for end in ends:
            assert end.receive() == wire(random_image(seq, LARGE), seq)


def test_a_subscriber_that_does_not_read_blocks_no_other_and_gets_whole_images_later(
        way, name, publisher, subscribe):
    stuck, reading = subscribe(name, Image), subscribe(name, Image)
    for seq in range(1, 21):
        publish(publisher, random_image(seq, LARGE))
        assert reading.receive() == wire(random_image(seq, LARGE), seq)
        wait_for(lambda: not stuck.is_idle(), 'the begin of the first image')
    # first the image whose sending had started, not overwritten by later ones; then the newest
    assert stuck.receive() == wire(random_image(1, LARGE), 1)
    assert stuck.receive() == wire(random_image(20, LARGE), 20)
    publish(publisher, random_image(21, LARGE))
    assert stuck.receive() == wire(random_image(21, LARGE), 21)


@pytest.mark.parametrize('leave_large, shape, sent', [
    (True, (1080, 1920, 3), {0}), (True, (480, 640, 3), None), (False, (1080, 1920, 3), None)])
def test_large_images_can_be_left_to_a_thread(fast, name, subscribe, monkeypatch, leave_large,
                                              shape, sent):
    counts, catch_up = [], outbox.Outbox._catch_up

    def note(self, sock, message, count):
        counts.append(count)
        catch_up(self, sock, message, count)
    monkeypatch.setattr(outbox.Outbox, '_catch_up', note)
    publisher = ImagePublisher(name, leave_large)
    subscriber, image = subscribe(name, Image), random_image(1, shape)
    for seq in range(1, 4):
        publish(publisher, image)
        assert subscriber.receive() == wire(image, seq)
    # how much of each message the caller had sent
    assert set(counts) == sent if sent else all(counts)


@pytest.mark.parametrize('shape, sent', [((1080, 1920, 3), [4096, 4096]), ((480, 640, 3), [])])
def test_a_subscriber_may_read_the_first_bytes_of_a_large_image_first(
        fast, name, publisher, subscribe, monkeypatch, shape, sent):
    """When the sender gives up its processor for once, only they are sent."""
    subscriber, image, waiting = subscribe(name, Image), random_image(1, shape), []
    monkeypatch.setattr(os, 'sched_yield', lambda: waiting.append(subscriber.waiting_bytes()))
    for seq in (1, 2):
        # what is published before the thread has ended its work is left to it, whole
        wait_for(lambda: not any(each._is_behind for each in
                                 publisher._outboxes._outboxes.values()), 'the thread')
        publish(publisher, image)
        assert subscriber.receive() == wire(image, seq)
    assert waiting == sent


def test_a_read_only_image_is_not_copied_again(fast, name, publisher, subscribe):
    subscriber, copied = subscribe(name, Image), []

    class Noted(np.ndarray):
        def reshape(self, *shape):
            copied.append(self)
            return super().reshape(*shape)
    first, second, writeable = (random_image(number).view(Noted) for number in range(3))
    for image in (first, second):
        image.setflags(write=False)
    for seq, image in enumerate((first, first, second, first, first, writeable, writeable,
                                 second, second), 1):
        publish(publisher, image)
        assert subscriber.receive() == wire(image, seq)
    assert [id(image) for image in copied] == [
        id(image) for image in (first, second, first, writeable, writeable, second)]


@pytest.fixture
def buffers(publisher, monkeypatch):
    """The buffers that a publisher has used, by number."""
    used, take = {}, publisher._pool.take

    def note(size):
        packet = take(size)
        used[id(packet)] = packet
        return packet
    monkeypatch.setattr(publisher._pool, 'take', note)
    return used


def test_buffers_are_reused_and_a_subscriber_that_does_not_read_keeps_two(
        fast, name, publisher, subscribe, buffers):
    reading = subscribe(name, Image)
    for seq in range(20):
        publish(publisher, random_image(seq, LARGE))
        reading.receive()
    assert len(buffers) <= 2
    subscribe(name, Image)
    for seq in range(20):
        publish(publisher, random_image(seq, LARGE))
        reading.receive()
    assert len(buffers) <= 4


def test_a_buffer_is_free_only_after_the_last_connection_has_sent_it(
        fast, name, publisher, subscribe, buffers):
    ends = [subscribe(name, Image) for _ in range(2)]
    publish(publisher, random_image(1, LARGE))
    packet, = buffers.values()
    ends[0].receive()
    wait_for(lambda: packet._owners == 1, 'the first sender')
    assert publisher._pool.free == []
    ends[1].receive()
    wait_for(lambda: publisher._pool.free == [packet], 'the buffer')


def test_a_buffer_is_free_again_when_its_subscriber_closes(
        fast, name, publisher, subscribe, buffers):
    stuck = subscribe(name, Image)
    for seq in range(5):
        publish(publisher, random_image(seq, LARGE))
    stuck.sock.close()
    wait_for(lambda: not publisher.get_num_connections(), 'the end of the connection')
    publish(publisher, random_image(6, LARGE))
    wait_for(lambda: len(publisher._pool.free) == len(buffers), 'all buffers')


def test_a_buffer_is_free_again_when_drawing_fails(fast, name, publisher, subscribe, buffers):
    subscriber = subscribe(name, Image)
    with pytest.raises(ZeroDivisionError):
        publisher.publish_drawn(lambda *_: 1 / 0, (4, 4, 3), 'bgr8', header())
    assert publisher._pool.free == list(buffers.values()) and subscriber.is_idle()


def test_buffers_of_another_size_are_dropped(fast, name, publisher, subscribe):
    subscriber = subscribe(name, Image)
    for seed, shape in enumerate([(480, 640, 3), (4, 4, 3), (480, 640, 3)]):
        publish(publisher, random_image(seed, shape))
        subscriber.receive()
        wait_for(lambda: publisher._pool.free, 'the buffer')
        assert len(publisher._pool.free) == 1


def test_a_closed_subscriber_is_removed_and_others_continue(
        way, name, publisher, subscribe):
    gone, there = subscribe(name, Image), subscribe(name, Image)
    gone.sock.close()

    def removed():
        publish(publisher, random_image(1))
        assert there.receive().endswith(random_image(1).tobytes())
        return publisher.get_num_connections() == 1
    wait_for(removed, 'the end of the connection')
    assert gone.transport.done and not there.transport.done


def test_a_queue_of_rospy_gets_images_that_do_not_change(fast, name, publisher, subscribe):
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        rospy.Publisher(name, Image, queue_size=1)      # in another part of the process
    stuck, reading = subscribe(name, Image), subscribe(name, Image)
    for seq in range(1, 6):
        publish(publisher, random_image(seq, LARGE))
        assert reading.receive() == wire(random_image(seq, LARGE), seq)
        wait_for(lambda: not stuck.is_idle(), 'the begin of the first image')
    assert stuck.receive() == wire(random_image(1, LARGE), 1)
    assert stuck.receive() == wire(random_image(5, LARGE), 5)
