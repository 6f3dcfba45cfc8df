"""Work on images while they arrive, and images that wait in the socket."""
import queue
import threading

import pytest
import rospy
from sensor_msgs.msg import Image

from img_recog.ros.transport import image_subscriber
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog_testing.tcpros import packet
from img_recog_testing.waiting import DEADLINE_S, wait_for

HEIGHT, WIDTH = 480, 640
STEP = 3 * WIDTH


def image(value, frame_id='camera', height=HEIGHT):
    return Image(height=height, width=WIDTH, encoding='rgb8', step=STEP,
                 data=bytes([value]) * (STEP * height),
                 header=rospy.Header(frame_id=frame_id))


class Worker:
    """An ImageSubscriber that looks at its images after some of their rows.

    seen: for each step, the message and the bytes before the row that it had wanted; None if they
    are not all there. done: the messages that are complete.
    """

    def __init__(self, name, rows):
        self.seen, self.done = queue.Queue(), queue.Queue()
        self._rows = rows
        self.subscriber = ImageSubscriber(name, self.done.put, begin=self.begin)

    def begin(self, msg):
        """Work on an image."""
        for row in self._rows:
            yield row * STEP
            values = set(bytes(msg.data[:max(0, row) * STEP]))
            self.seen.put((msg, row, values))

    def steps(self, count):
        """Return the next steps."""
        return [self.seen.get(timeout=DEADLINE_S) for _ in range(count)]

    def image(self):
        """Return the next complete image."""
        return self.done.get(timeout=DEADLINE_S)


def test_each_step_has_the_bytes_that_it_wanted_before_the_rest_is_sent(fast, name, publish_to):
    worker, publisher = Worker(name, [100, 101, 480]), publish_to(name, Image)
    for value in (1, 2, 3):
        data = packet(image(value))
        head = len(data) - STEP * HEIGHT
        first, second = head + 100 * STEP, head + 101 * STEP
        publisher.send_bytes(data[:first])
        (msg, row, values), = worker.steps(1)
        assert (row, values, msg.header.frame_id, msg.height) == (100, {value}, 'camera', HEIGHT)
        assert worker.seen.empty()
        publisher.send_bytes(data[first:second])
        assert worker.steps(1) == [(msg, 101, {value})]
        assert worker.done.empty()
        publisher.send_bytes(data[second:])
        assert worker.steps(1) == [(msg, 480, {value})]
        assert worker.image() is msg and bytes(msg.data) == image(value).data
        worker.subscriber.release(msg)


def test_the_header_may_come_byte_by_byte(fast, name, publish_to):
    worker, publisher = Worker(name, [10]), publish_to(name, Image)
    data = packet(image(7))
    for start in range(0, 300, 7):
        publisher.sock.sendall(data[start:min(start + 7, 300)])
    assert worker.done.empty()
    publisher.send_bytes(data[300:])
    assert worker.steps(1)[0][1:] == (10, {7})
    assert bytes(worker.image().data) == image(7).data


@pytest.mark.parametrize('wanted', [0, -5, 10 * HEIGHT])
def test_wishes_outside_of_the_image(fast, name, publish_to, wanted):
    worker, publisher = Worker(name, [wanted, 20]), publish_to(name, Image)
    for value in (4, 5):
        publisher.send(image(value))
        assert [step[1] for step in worker.steps(2)] == [wanted, 20]
        assert bytes(worker.image().data) == image(value).data


def test_sizes_and_texts_that_change_from_image_to_image(fast, name, publish_to):
    worker, publisher = Worker(name, [50]), publish_to(name, Image)
    for value, (frame_id, height) in enumerate([
            ('camera', 480), ('c' * 40, 480), ('', 480), ('camera', 100), ('camera', 480)]):
        sent = image(value, frame_id, height)
        publisher.send(sent)
        msg, row, values = worker.steps(1)[0]
        assert (row, values, msg.header.frame_id) == (50, {value}, frame_id)
        got = worker.image()
        assert got is msg and bytes(got.data) == sent.data
        worker.subscriber.release(got)


def test_an_image_with_long_texts_comes_without_steps(fast, name, publish_to):
    worker, publisher = Worker(name, [50]), publish_to(name, Image)
    publisher.send(image(1, height=4))      # rospy itself reads the begin of the first message
    assert bytes(worker.image().data) == image(1, height=4).data
    sent = image(3, 'f' * 5000)
    publisher.send(sent)
    assert bytes(worker.image().data) == sent.data
    assert worker.seen.empty()


def test_a_small_image_comes_without_steps(fast, name, publish_to):
    worker, publisher = Worker(name, [1]), publish_to(name, Image)
    publisher.send(image(3, height=4))
    assert bytes(worker.image().data) == image(3, height=4).data
    assert worker.seen.empty()


def test_large_messages_that_are_no_images_are_dropped(fast, name, publish_to):
    worker, publisher = Worker(name, [50]), publish_to(name, Image)
    data = bytearray(packet(image(1)))
    for position in (16, 34):       # the lengths of the frame_id and of the encoding
        broken = bytearray(data)
        broken[position:position + 4] = b'\xff\xff\xff\x7f'
        publisher.sock.sendall(broken)
    publisher.send(image(2))
    wait_for(lambda: not worker.done.empty(), 'the image')
    assert bytes(worker.image().data) == image(2).data


def test_an_error_in_a_step_is_logged_and_the_image_delivered(fast, name, publish_to,
                                                              monkeypatch):
    lines, images = [], queue.Queue()
    monkeypatch.setattr(rospy.topics, 'logerr', lines.append)

    def begin(msg):
        yield STEP
        raise ZeroDivisionError
    ImageSubscriber(name, images.put, begin=begin)
    publisher = publish_to(name, Image)
    for value in (1, 2):
        publisher.send(image(value))
        assert bytes(images.get(timeout=DEADLINE_S).data) == image(value).data
    assert len(lines) == 2 and all('ZeroDivisionError' in line for line in lines)


def test_a_publisher_that_ends_within_an_image(fast, name, publish_to):
    worker, publisher = Worker(name, [50, 400]), publish_to(name, Image)
    publisher.sock.sendall(packet(image(1))[:100 * STEP])
    assert worker.steps(1)[0][1] == 50
    publisher.sock.close()
    publisher.join()
    assert worker.done.empty() and worker.seen.empty()
    publish_to(name, Image).send(image(2))
    assert bytes(worker.image().data) == image(2).data


def test_the_images_that_wait_in_the_socket_are_counted(fast, name, publish_to):
    counts, may_go_on = queue.Queue(), threading.Event()

    def handle(msg):
        counts.put((image_subscriber.backlog(msg), msg.data[0]))
        may_go_on.wait(DEADLINE_S)
    ImageSubscriber(name, handle)
    publisher = publish_to(name, Image)
    small = [Image(height=1, width=100, encoding='mono8', step=100, data=bytes([value]) * 100)
             for value in range(4)]
    publisher.send(small[0])
    assert counts.get(timeout=DEADLINE_S) == (0, 0)
    publisher.sock.sendall(b''.join(map(packet, small[1:])))
    may_go_on.set()
    assert [counts.get(timeout=DEADLINE_S) for _ in range(3)] == [(2, 1), (1, 2), (0, 3)]


def test_there_is_no_backlog_without_a_socket():
    assert image_subscriber.backlog(Image()) == 0
