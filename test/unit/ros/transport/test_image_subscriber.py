"""Images from a socket into kept memory, by a connection as rospy makes them."""
import io
import socket
import struct
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from rospy.exceptions import TransportTerminated
from rospy.impl.tcpros_pubsub import TCPROSSub
from sensor_msgs.msg import Image

from img_recog.ros.transport import image_subscriber
from img_recog.ros.transport.image_subscriber import ImageSubscriber


def image(seed, height=48, width=64, encoding='rgb8', frame_id='camera'):
    data = np.random.RandomState(seed).randint(0, 256, height * width * 3).astype(np.uint8)
    msg = Image(height=height, width=width, encoding=encoding, step=3 * width,
                data=data.tobytes())
    msg.header.seq, msg.header.frame_id = seed, frame_id
    msg.header.stamp.secs, msg.header.stamp.nsecs = 1000 + seed, 5
    return msg


def packet(msg):
    buffer = io.BytesIO()
    msg.serialize(buffer)
    return struct.pack('<I', buffer.tell()) + buffer.getvalue()


class Connection:
    """A subscriber's end of a connection, which reads as rospy's does."""

    def __init__(self, monkeypatch):
        self.endpoint_id = '/camera'
        self.theirs, self.sock = socket.socketpair()
        self.protocol = TCPROSSub('/topic', Image)
        self.buffer = io.BytesIO()
        topic = SimpleNamespace(c_lock=threading.RLock(), connections=[],
                                add_connection=lambda connection: True)
        monkeypatch.setattr(image_subscriber.rospy, 'Subscriber',
                            lambda *args, **kwargs: SimpleNamespace(impl=topic))
        self.subscriber = ImageSubscriber('/topic', None)
        assert topic.add_connection(self)

    def send(self, data):
        thread = threading.Thread(target=self.theirs.sendall, args=(data,), daemon=True)
        thread.start()

    def receive(self):
        messages = []
        while not messages:
            if self.buffer.tell() >= 4:
                self.protocol.read_messages(self.buffer, messages, self.sock)
            if not messages:
                data = self.sock.recv(self.protocol.buff_size)
                assert data
                self.buffer.write(data)
        return messages


@pytest.fixture
def connection(monkeypatch):
    made = Connection(monkeypatch)
    yield made
    made.theirs.close()
    made.sock.close()


def assert_equal(got, sent):
    assert bytes(got.data) == sent.data
    for name in ('header', 'height', 'width', 'encoding', 'is_bigendian', 'step'):
        assert getattr(got, name) == getattr(sent, name)


def test_images_of_many_sizes_one_after_the_other(connection):
    sent = [image(number, *size) for number, size in enumerate(
        [(480, 640), (1, 1), (1080, 1920), (0, 0), (48, 64), (480, 640)])]
    connection.send(b''.join(map(packet, sent)))
    got = []
    while len(got) < len(sent):
        for msg in connection.receive():
            assert_equal(msg, sent[len(got)])
            got.append(msg)


def test_texts_of_any_length(connection):
    for number, (encoding, frame_id) in enumerate([('', ''), ('x' * 1000, 'ä/' * 500)]):
        sent = image(number, encoding=encoding, frame_id=frame_id)
        connection.send(packet(sent))
        assert_equal(connection.receive()[0], sent)


def test_what_was_read_with_the_handshake_counts(connection):
    sent = [image(1), image(2)]
    data = b''.join(map(packet, sent))
    connection.buffer.write(data[:5000])
    connection.send(data[5000:])
    assert_equal(connection.receive()[0], sent[0])
    assert_equal(connection.receive()[0], sent[1])


def test_memory_is_used_again_only_after_release(connection):
    connection.protocol.buff_size = 4       # as after the first message
    connection.send(b''.join(packet(image(number)) for number in range(3)))
    first, second = connection.receive()[0], connection.receive()[0]
    assert first.memory is not second.memory
    memory = first.memory
    connection.subscriber.release(first)
    third = connection.receive()[0]
    assert third.memory is memory
    assert_equal(second, image(1))
    assert_equal(third, image(2))


def test_a_release_counts_once(connection):
    connection.send(packet(image(0)))
    msg = connection.receive()[0]
    connection.subscriber.release(msg)
    connection.subscriber.release(msg)
    connection.subscriber.release(Image())
    connection.send(packet(image(1)) + packet(image(2)))
    first, second = connection.receive()[0], connection.receive()[0]
    assert first.memory is not second.memory


def test_a_larger_image_than_before(connection):
    connection.send(packet(image(0, 2, 2)))
    connection.subscriber.release(connection.receive()[0])
    sent = image(1, 480, 640)
    connection.send(packet(sent))
    assert_equal(connection.receive()[0], sent)


def test_a_length_that_is_never_sent_takes_no_memory(connection):
    def kilobytes():
        with open('/proc/self/status') as file:
            return next(int(line.split()[1]) for line in file if line.startswith('VmRSS'))
    before = kilobytes()
    connection.theirs.sendall(struct.pack('<I', 0xffffffff) + b'few')
    connection.theirs.close()
    with pytest.raises(TransportTerminated):
        connection.receive()
    assert kilobytes() - before < 100000


@pytest.mark.parametrize('data', [
    b'', b'123', bytes(range(20)), b'\xff' * 64, packet(image(0))[4:-1],
    packet(image(0))[4:-48 * 64 * 3 - 4] + b'\xff\xff\xff\xff' + bytes(48 * 64 * 3)])
def test_what_is_no_image_is_skipped_with_a_line_and_the_next_one_comes(
        connection, monkeypatch, data):
    lines = []
    monkeypatch.setattr(connection.subscriber, '_warn',
                        lambda text, *values: lines.append(text % values))
    connection.protocol.buff_size = 4
    connection.send(struct.pack('<I', len(data)) + data + packet(image(1)))
    assert_equal(connection.receive()[0], image(1))
    assert len(lines) == 1 and 'of /camera skipped: its {} bytes'.format(len(data)) in lines[0]


def test_memory_of_a_huge_image_is_given_back(connection):
    connection.send(packet(image(0, 1000, 1000)))
    huge = connection.receive()[0]
    memory = huge.memory
    connection.subscriber.release(huge)
    connection.send(packet(image(1)))
    assert connection.receive()[0].memory is not memory
    assert not connection.subscriber._free


def test_a_publisher_that_ends_in_the_midst_of_an_image(connection):
    connection.theirs.sendall(packet(image(0))[:3000])
    connection.theirs.close()
    with pytest.raises(TransportTerminated):
        connection.receive()
