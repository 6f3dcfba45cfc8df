"""Images to real connections of rospy: the same bytes that rospy sends."""
import io
import warnings

import numpy as np
import pytest
import rospy
from rospy.msg import serialize_message
from sensor_msgs.msg import Image, PointCloud2, PointField
from std_msgs.msg import Header

from img_recog.ros.transport.image_publisher import ImagePublisher, LargePublisher
from img_recog_helpers.extraction import random_image
from img_recog_helpers.waiting import wait_for

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


def test_who_draws_knows_what_was_drawn_before_unless_an_outbox_has_it(
        fast, name, publisher, subscribe):
    subscriber, notes = subscribe(name, Image), []

    def draw(result, note):
        if note is None:
            result[:] = 0
        result.flat[len(notes)] = 1
        notes.append(note)
        return len(notes)

    def publish(shape):
        publisher.publish_drawn(draw, shape, 'bgr8', header())
    for shape in ((4, 4, 3), (4, 4, 3), (2, 8, 3), LARGE):
        publish(shape)
        sent = np.frombuffer(subscriber.receive()[-int(np.prod(shape)):], np.uint8)
        assert np.flatnonzero(sent).tolist() == ([0, 1] if len(notes) == 2 else [len(notes) - 1])
    subscriber.fill()
    publish(LARGE)      # an outbox keeps it
    publish(LARGE)
    assert notes[:3] == [None, 1, None] and notes[3] is None and notes[5] is None


def test_a_cloud_of_points(way, name, subscribe):
    publisher, data = LargePublisher(name, PointCloud2), random_image(3, (4, 6, 32))
    msg = PointCloud2(header(), 4, 6, [PointField('x', 0, PointField.FLOAT32, 1)], False, 32, 192,
                      b'', True)
    subscriber = subscribe(name, PointCloud2)
    for seq in (1, 2):
        publisher.publish_data(lambda result: np.copyto(result, data), data.shape, msg)
        wanted = io.BytesIO()
        msg.data = data.tobytes()
        serialize_message(wanted, seq, msg)
        msg.data = b''
        assert subscriber.receive() == wanted.getvalue()


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


def check_stuck(name, publisher, subscribe, count):
    """Publish images to one who reads and one who does not; return the latter's end."""
    stuck, reading = subscribe(name, Image), subscribe(name, Image)
    for seq in range(1, count + 1):
        publish(publisher, random_image(seq, LARGE))
        assert reading.receive() == wire(random_image(seq, LARGE), seq)
        wait_for(lambda: not stuck.is_idle(), 'the begin of the first image')
    # first the image whose sending had started, not overwritten by later ones; then the newest
    assert stuck.receive() == wire(random_image(1, LARGE), 1)
    assert stuck.receive() == wire(random_image(count, LARGE), count)
    return stuck


def test_a_subscriber_that_does_not_read_blocks_no_other_and_gets_whole_images_later(
        way, name, publisher, subscribe):
    stuck = check_stuck(name, publisher, subscribe, 20)
    publish(publisher, random_image(21, LARGE))
    assert stuck.receive() == wire(random_image(21, LARGE), 21)


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
    check_stuck(name, publisher, subscribe, 5)
