"""Whether all that has arrived was passed on."""
import threading

import pytest
from std_msgs.msg import String

from img_recog.ros.transport.settled_subscriber import SettledSubscriber
from img_recog_helpers.waiting import wait_for
from img_recog_helpers.wire import packet

pytestmark = pytest.mark.usefixtures('fast')


def test_it_is_settled_when_the_callbacks_have_returned(name, publish_to):
    received, may_return = [], threading.Event()

    def receive(msg, header):
        received.append(msg.data)
        may_return.wait()
    subscriber = SettledSubscriber(name, String, receive)
    end = publish_to(name, String)
    wait_for(subscriber.is_settled, 'a connection without messages')
    end.sock.sendall(packet(String('first')) + packet(String('second')))
    assert not subscriber.is_settled()
    wait_for(lambda: received, 'the first message')
    assert received == ['first'] and not subscriber.is_settled()
    may_return.set()
    wait_for(subscriber.is_settled, 'the end of the callbacks')
    assert received == ['first', 'second']
    subscriber.unregister()


def test_a_message_that_has_not_come_whole(name, publish_to):
    received = []
    subscriber = SettledSubscriber(name, String, lambda msg, _: received.append(msg.data))
    end = publish_to(name, String)
    wait_for(subscriber.is_settled, 'a connection')
    data = packet(String('whole'))
    end.sock.sendall(data[:-1])
    wait_for(lambda: not subscriber.is_settled(), 'a part of the message')
    end.sock.sendall(data[-1:])
    wait_for(lambda: received == ['whole'] and subscriber.is_settled(), 'the message')
    subscriber.unregister()


def test_two_subscribers_of_a_topic(name, publish_to):
    received = []
    before = SettledSubscriber(name, String, lambda msg, _: received.append(msg.data))
    subscriber = SettledSubscriber(name, String, lambda msg, _: received.append(msg.data))
    end = publish_to(name, String)
    for count in (2, 4):
        end.sock.sendall(packet(String('a')))
        wait_for(lambda: len(received) == count, 'the message in both callbacks')
        wait_for(lambda: subscriber.is_settled() and before.is_settled(), 'their ends')
    before.unregister()
    subscriber.unregister()


def test_a_publisher_that_was_killed(name, publish_to):
    subscriber = SettledSubscriber(name, String, lambda msg, _: None)
    end = publish_to(name, String)
    wait_for(lambda: len(subscriber.publishers()) == 1, 'a connection')
    end.sock.close()
    wait_for(lambda: subscriber.publishers() == set(), 'the end of the connection')
    subscriber.unregister()
