"""Subscribers that do not read are found, by the sockets of a node."""
import threading

import pytest
import rospy
from std_msgs.msg import String

from img_recog.ros.transport import subscribers
from img_recog.ros.transport.subscribers import SubscriberCheck
from img_recog.ros.transport.switch import VARIABLE
from img_recog_testing.waiting import wait_for

pytestmark = pytest.mark.usefixtures('fast')


@pytest.fixture(autouse=True)
def short_wait(monkeypatch):
    monkeypatch.setattr(subscribers, '_WAIT_S', 0.01)


def names(check, topic):
    """Return what is found on a topic; other tests of this process leave theirs."""
    return [name for name in check.not_reading() if '({})'.format(topic) in name]


@pytest.mark.parametrize('queue_size', [1, None])
def test_it_is_named_at_the_second_check_until_it_reads(name, subscribe, queue_size, recwarn):
    publisher = rospy.Publisher(name, String, queue_size=queue_size)
    ends, check = [subscribe(name, String) for _ in range(2)], SubscriberCheck()
    assert names(check, name) == [] == names(check, name)
    ends[0].fill()
    assert names(check, name) == []
    assert names(check, name) == ['{} ({})'.format(ends[0].transport.endpoint_id, name)]
    ends[0].sock.setblocking(False)
    with pytest.raises(BlockingIOError):
        while True:
            ends[0].sock.recv(1 << 20)
    assert names(check, name) == []
    publisher.unregister()


def test_it_is_not_found_after_it_has_gone(name, subscribe):
    publisher = rospy.Publisher(name, String, queue_size=1)
    end, check = subscribe(name, String), SubscriberCheck()
    end.fill()
    names(check, name)
    end.sock.close()
    assert names(check, name) == []
    end.transport.close()
    wait_for(lambda: publisher.get_num_connections() == 0, 'the end of the connection')
    assert names(check, name) == []


def test_a_full_buffer_that_is_read_meanwhile_is_none(name, subscribe, monkeypatch):
    rospy.Publisher(name, String, queue_size=1)
    end, check = subscribe(name, String), SubscriberCheck()
    end.fill()
    end.sock.setblocking(False)
    assert names(check, name) == []
    monkeypatch.setattr(subscribers, '_WAIT_S', 30.0)

    def read_later(*_):
        end.sock.settimeout(30)
        while end.sock.recv(1 << 20):
            pass
    threading.Thread(target=read_later, daemon=True).start()
    assert names(check, name) == []
    end.transport.close()


def test_plain_rospy_does_not_know_them(monkeypatch):
    monkeypatch.setenv(VARIABLE, '1')
    assert SubscriberCheck().not_reading() is None
