"""Small messages to real connections of rospy, sent in the calling thread."""
import fcntl
import resource
import socket
import threading

import pytest
import rospy
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog_helpers.tcpros import packet
from img_recog_helpers.waiting import DEADLINE_S, wait_for

_FIRST_TOO_HIGH_FOR_SELECT = 1024


@pytest.fixture
def publisher(name):
    return DirectPublisher(name, String)


def impl_of(name):
    """Return what rospy has of a topic."""
    return rospy.topics.get_topic_manager().get_publisher_impl(name)


def text(number):
    return String('message {}'.format(number))


def test_all_subscribers_get_each_message(way, name, publisher, subscribe):
    publisher.publish(text(0))
    ends = [subscribe(name, String) for _ in range(3)]
    assert publisher.get_num_connections() == 3
    for number in range(10):
        publisher.publish(text(number))
        for end in ends:
            assert end.receive() == packet(text(number))


def send_together(publisher, *messages):
    for msg in messages:
        publisher.add(msg)
    publisher.flush()


def test_a_new_subscriber_gets_the_latched_message(way, name, subscribe):
    publisher = DirectPublisher(name, String, latch=True)
    for number in range(2):
        publisher.publish(text(number))
        assert subscribe(name, String).receive() == packet(text(number))
    send_together(publisher, text(2), text(3))
    assert subscribe(name, String).receive() == packet(text(3))


def test_a_subscriber_that_does_not_read_does_not_block_others(way, name, publisher, subscribe):
    stuck, reading = subscribe(name, String), subscribe(name, String)
    stuck.fill()
    for number in range(10):
        publisher.publish(text(number))
        assert reading.receive() == packet(text(number))


def ends(function, *arguments):
    """Call a function in a thread, so that a test fails if it blocks; return its result."""
    results = []
    thread = threading.Thread(target=lambda: results.append(function(*arguments)), daemon=True)
    thread.start()
    thread.join(DEADLINE_S)
    assert not thread.is_alive(), 'it blocks'
    return results[0]


def test_a_subscriber_whose_buffer_is_full_misses_all_but_two_messages(fast, name, publisher,
                                                                       subscribe):
    """Plain rospy has a queue, where the last ten messages wait."""
    end = subscribe(name, String)
    count = end.fill()
    for number in range(10):
        publisher.publish(text(number))
    end.read(count)
    assert end.receive() == packet(text(0))     # was begun; then the newest
    assert end.receive() == packet(text(9)) and end.is_idle()
    for number in range(10):
        publisher.publish(text(number))
        assert end.receive() == packet(text(number))


def large(letter):
    """Return a message that is larger than the buffers of a socket."""
    return String(letter * (8 << 20))


def test_a_message_larger_than_the_buffer_does_not_block(fast, name, publisher, subscribe):
    """A socket has room for its beginning only."""
    stuck, reading = subscribe(name, String), subscribe(name, String)
    for msg in (large('a'), text(1), text(2)):
        ends(publisher.publish, msg)
        assert reading.receive() == packet(msg)
    assert stuck.receive() == packet(large('a'))
    assert stuck.receive() == packet(text(2)) and stuck.is_idle()


def test_a_latched_message_larger_than_the_buffer_does_not_block(fast, name, subscribe):
    publisher = DirectPublisher(name, String, latch=True)
    publisher.publish(large('a'))
    end = ends(subscribe, name, String)
    ends(publisher.publish, text(1))
    assert end.receive() == packet(large('a')) and end.receive() == packet(text(1))


def test_a_connection_that_is_closed_while_a_message_waits_is_removed(fast, name, publisher,
                                                                      subscribe):
    before = set(threading.enumerate())
    gone, closed = subscribe(name, String), subscribe(name, String)
    ends(publisher.publish, large('a'))
    ends(publisher.publish, large('b'))
    assert len(set(threading.enumerate()) - before) == 2
    gone.sock.close()               # by the subscriber
    closed.transport.close()        # by rospy
    wait_for(lambda: publisher.get_num_connections() == 0, 'the end of both connections')
    wait_for(lambda: set(threading.enumerate()) <= before, 'the end of the threads')


def test_a_slow_subscriber_gets_whole_messages_in_order_and_the_last_one(fast, name, publisher,
                                                                         subscribe):
    end, received = subscribe(name, String), []
    end.transport.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1)     # the minimum
    messages = [String('{} '.format(number) * 3000) for number in range(300)]
    sent = [packet(msg) for msg in messages]

    def read():
        while not received or received[-1] != sent[-1]:
            received.append(end.receive())
    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    for msg in messages:
        publisher.publish(msg)
    reader.join(DEADLINE_S)
    assert received[-1] == sent[-1]
    assert received == sorted(received, key=sent.index)


def test_the_latched_message_is_the_last_one_also_if_a_buffer_is_full(fast, name, subscribe):
    publisher = DirectPublisher(name, String, latch=True)
    subscribe(name, String).fill()
    publisher.publish(text(1))
    assert subscribe(name, String).receive() == packet(text(1))


def test_a_topic_that_rospy_closes_meanwhile(fast, name, publisher, subscribe):
    """At the shutdown of a node, another thread closes its topics step by step."""
    topic = impl_of(name)
    subscribe(name, String).sock.close()
    topic.subscriber_listeners = None
    publisher.publish(text(1))                  # it finds that the subscriber is gone
    publisher.publish(text(2))
    assert publisher.get_num_connections() == 0
    publisher.add(text(3))
    topic.closed, topic.publock = True, None
    publisher.flush()
    with pytest.raises(rospy.ROSException):     # which ends a node quietly
        publisher.publish(text(4))


@pytest.fixture
def high():
    """A function that moves a socket to a descriptor that select.select refuses."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard <= _FIRST_TOO_HIGH_FOR_SELECT + 8:
        pytest.skip('this process may have {} descriptors only'.format(hard))
    resource.setrlimit(resource.RLIMIT_NOFILE,
                       (max(soft, _FIRST_TOO_HIGH_FOR_SELECT + 8), hard))

    def move(sock):
        moved = socket.socket(fileno=fcntl.fcntl(
            sock.fileno(), fcntl.F_DUPFD_CLOEXEC, _FIRST_TOO_HIGH_FOR_SELECT))
        sock.close()
        return moved
    yield move
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_descriptors_above_1023(fast, name, publisher, subscribe, high):
    end = subscribe(name, String)
    end.transport.socket = high(end.transport.socket)
    assert end.transport.socket.fileno() >= _FIRST_TOO_HIGH_FOR_SELECT
    publisher.publish(text(1))
    assert end.receive() == packet(text(1))
    count = end.fill()
    publisher.publish(text(2))
    end.read(count)
    assert end.receive() == packet(text(2))
    end.transport.socket.close()


def test_several_messages_at_once(way, name, publisher, subscribe):
    send_together(publisher, text(0), text(1))
    ends = [subscribe(name, String) for _ in range(2)]
    send_together(publisher, text(2), text(3), text(4))
    publisher.publish(text(5))
    for end in ends:
        assert [end.receive() for _ in range(4)] == [packet(text(number)) for number in
                                                     (2, 3, 4, 5)]


def test_messages_that_are_sent_together_are_counted(fast, name, publisher, subscribe):
    end = subscribe(name, String)
    send_together(publisher, *map(text, range(3)))
    publisher.publish(text(3))
    for number in range(4):
        assert end.receive() == packet(text(number))
    connection, = impl_of(name).connections
    assert connection.stat_num_msg == 4
    assert connection.stat_bytes == sum(len(packet(text(number))) for number in range(4))


def test_a_message_may_be_changed_after_it_was_added(way, name, publisher, subscribe):
    end, msg = subscribe(name, String), String()
    for number in range(3):
        msg.data = text(number).data
        publisher.add(msg)
    msg.data = 'not sent'
    publisher.flush()
    publisher.flush()
    assert [end.receive() for _ in range(3)] == [packet(text(number)) for number in range(3)]


def test_a_message_that_cannot_be_serialized_leaves_the_others_whole(fast, name, publisher,
                                                                     subscribe):
    end = subscribe(name, String)
    publisher.add(text(1))
    with pytest.raises(UnicodeEncodeError):
        publisher.publish(String('\udcff'))
    publisher.publish(text(2))
    assert [end.receive() for _ in range(2)] == [packet(text(1)), packet(text(2))]


def test_messages_are_sent_when_flush_or_publish_returns(fast, name, publisher, subscribe):
    end = subscribe(name, String)
    end.sock.setblocking(False)
    publisher.add(text(1))
    assert end.is_idle()
    publisher.flush()
    assert end.sock.recv(1 << 16) == packet(text(1))
    publisher.publish(text(2))
    assert end.sock.recv(1 << 16) == packet(text(2))


def test_a_latched_message_that_is_changed_later_is_latched_as_it_was(fast, name, subscribe):
    publisher, msg = DirectPublisher(name, Imu, latch=True), Imu()
    for number in range(2):
        msg.header.frame_id = 'frame {}'.format(number)
        publisher.publish(msg)
        msg.header.frame_id = 'not published'
        latched = Imu().deserialize(subscribe(name, Imu).receive()[4:])
        assert latched.header.frame_id == 'frame {}'.format(number)


def test_a_message_that_cannot_be_serialized_is_not_latched(fast, name, subscribe):
    publisher = DirectPublisher(name, String, latch=True)
    publisher.publish(text(1))
    with pytest.raises(Exception):
        publisher.publish(String(7))
    assert subscribe(name, String).receive() == packet(text(1))


def test_a_message_that_is_published_while_a_subscriber_connects_comes_once(fast, name,
                                                                            subscribe):
    publisher = DirectPublisher(name, String, latch=True)
    publisher.publish(text(0))
    topic = impl_of(name)
    other = threading.Thread(target=publisher.publish, args=(text(1),), daemon=True)

    class Listener(rospy.SubscribeListener):
        """rospy calls it after it has added a connection and before the latched message."""

        def peer_subscribe(self, *_):
            if not other.ident:
                other.start()
                other.join(0.2)
    topic.add_subscriber_listener(Listener())
    end = subscribe(name, String)
    other.join(DEADLINE_S)
    assert [end.receive() for _ in range(2)] == [packet(text(0)), packet(text(1))]
    assert end.is_idle()


def test_what_was_added_before_a_subscriber_connects_comes_once(fast, name, subscribe):
    publisher = DirectPublisher(name, String, latch=True)
    before = subscribe(name, String)
    publisher.add(text(0))
    publisher.add(text(1))
    new = subscribe(name, String)
    publisher.flush()
    publisher.publish(text(2))
    assert [before.receive() for _ in range(3)] == [packet(text(number)) for number in range(3)]
    assert [new.receive() for _ in range(2)] == [packet(text(1)), packet(text(2))]


def test_headers_are_counted(way, name, subscribe):
    publisher = DirectPublisher(name, Imu)
    end = subscribe(name, Imu)
    send_together(publisher, Imu(), Imu())
    publisher.publish(Imu())
    for seq in (1, 2, 3):
        assert Imu().deserialize(end.receive()[4:]).header.seq == seq


def test_publishing_on_a_closed_topic_is_an_error(way, name, publisher):
    impl_of(name).close()
    with pytest.raises(rospy.ROSException, match='closed topic'):
        publisher.publish(text(1))
