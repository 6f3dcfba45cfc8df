"""Messages that are no images: they are skipped, and the next one arrives."""
import queue
import struct

import pytest
from sensor_msgs.msg import Image

from img_recog.ros.transport import image_subscriber
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog_helpers.tcpros import packet
from img_recog_helpers.waiting import DEADLINE_S

SIZE = 5000


def image(size):
    """Return an image whose message has `size` bytes."""
    msg = Image(encoding='mono8', height=1)
    msg.data = bytes(size - len(packet(msg)) + 4)
    msg.width = msg.step = len(msg.data)
    return msg


@pytest.fixture
def images():
    return queue.Queue()


@pytest.fixture
def lines(monkeypatch):
    """The warnings."""
    lines = []
    monkeypatch.setattr(image_subscriber.rospy, 'logwarn', lambda *words: lines.append(words))
    monkeypatch.setattr(image_subscriber.ThrottledWarning, '__call__',
                        lambda self, text, *values: lines.append(text % values))
    return lines


# plain rospy closes the connection and opens a new one
@pytest.mark.parametrize('data', [
    b'', b'123', bytes(range(20)), b'\xff' * 64, packet(image(SIZE))[4:-1],
    packet(image(SIZE))[4:-len(image(SIZE).data) - 4] + b'\xff' * 4 + image(SIZE).data],
    ids=['empty', 'short', 'numbers', 'ones', 'truncated', 'too long'])
def test_data_that_is_not_an_image_is_skipped_with_a_line_and_the_next_image_arrives(
        fast, name, images, lines, publish_to, data):
    refused = []
    ImageSubscriber(name, images.put, refused.append)
    publisher = publish_to(name, Image, begin=False)
    publisher.transport.protocol.buff_size = 4      # like after the first message
    publisher.begin()
    publisher.send_bytes(struct.pack('<I', len(data)) + data + packet(image(SIZE)))
    assert bytes(images.get(timeout=DEADLINE_S).data) == image(SIZE).data
    assert refused == lines and len(lines) == 1
    assert 'of {} skipped: {} bytes, no sensor_msgs/Image: '.format(
        publisher.transport.endpoint_id, len(data)) in lines[0]
