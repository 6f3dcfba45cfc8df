"""Messages that are longer than an image may be: they take no memory, and the next one arrives."""
import queue
import struct

import pytest
from sensor_msgs.msg import Image

from img_recog.ros.transport import image_subscriber
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog_testing.tcpros import packet
from img_recog_testing.waiting import DEADLINE_S

LIMIT = 5000


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


@pytest.mark.parametrize('sent_first', [4, 10, 3000])
@pytest.mark.parametrize('size', [LIMIT + 1, 10 * LIMIT, 3000000])
def test_a_message_above_the_limit_is_read_and_dropped(fast, name, images, lines, publish_to, size,
                                                       sent_first):
    refused = []
    ImageSubscriber(name, images.put, LIMIT, refused.append)
    publisher = publish_to(name, Image, begin=False)
    data = packet(image(size)) + packet(image(LIMIT))
    # what rospy reads with the handshake
    publisher.transport.read_buff.write(data[:sent_first])
    publisher.begin()
    publisher.send_bytes(data[sent_first:])
    got = images.get(timeout=DEADLINE_S)
    assert len(got.data) == len(image(LIMIT).data) and images.empty()
    assert refused == lines == ['image of {} skipped: {} bytes, at most {} are read'.format(
        publisher.transport.endpoint_id, size, LIMIT)]


# plain rospy closes the connection and opens a new one
@pytest.mark.parametrize('data', [
    b'', b'123', bytes(range(20)), b'\xff' * 64, packet(image(LIMIT))[4:-1],
    packet(image(LIMIT))[4:-len(image(LIMIT).data) - 4] + b'\xff' * 4 + image(LIMIT).data],
    ids=['empty', 'short', 'numbers', 'ones', 'truncated', 'too long'])
def test_data_that_is_not_an_image_is_skipped_with_a_line_and_the_next_image_arrives(
        fast, name, images, lines, publish_to, data):
    refused = []
    ImageSubscriber(name, images.put, LIMIT, refused.append)
    publisher = publish_to(name, Image, begin=False)
    publisher.transport.protocol.buff_size = 4      # like after the first message
    publisher.begin()
    publisher.send_bytes(struct.pack('<I', len(data)) + data + packet(image(LIMIT)))
    assert bytes(images.get(timeout=DEADLINE_S).data) == image(LIMIT).data
    assert refused == lines and len(lines) == 1
    assert 'of {} skipped: {} bytes, no sensor_msgs/Image: '.format(
        publisher.transport.endpoint_id, len(data)) in lines[0]


def kilobytes():
    """Return the physical memory of this process."""
    with open('/proc/self/status') as file:
        return next(int(line.split()[1]) for line in file if line.startswith('VmRSS'))


def test_a_wrong_length_without_a_limit_takes_no_memory(fast, name, images, publish_to):
    ImageSubscriber(name, images.put)
    publisher, before = publish_to(name, Image), kilobytes()
    publisher.sock.sendall(struct.pack('<I', 0xffffffff) + b'few')
    publisher.sock.close()
    publisher.join()
    assert kilobytes() - before < 100000


def test_a_wrong_length_takes_no_memory_however_much_follows(fast, name, images, lines,
                                                             publish_to):
    ImageSubscriber(name, images.put, LIMIT)
    publisher = publish_to(name, Image)
    before = kilobytes()
    publisher.sock.sendall(struct.pack('<I', 0xffffffff))
    for _ in range(300):
        publisher.sock.sendall(bytes(1 << 20))      # returns when it is read, but for the buffer
    assert kilobytes() - before < 50000 and len(lines) == 1
    publisher.sock.close()
    publisher.join()
