"""Topics with the real classes of rospy, without a master, connected by socket pairs."""
import itertools

import pytest
import rospy

from img_recog.ros.transport.switch import VARIABLE
from img_recog_helpers.tcpros import PublisherEnd, SubscriberEnd

_numbers = itertools.count()


def _set(monkeypatch, value):
    monkeypatch.setenv(VARIABLE, value)
    monkeypatch.setattr(rospy.topics, 'is_initialized', lambda: True)


@pytest.fixture(params=['', '1'], ids=['fast', 'plain'])
def way(request, monkeypatch):
    """Run the test with the fast transport and with plain rospy, which must behave the same."""
    _set(monkeypatch, request.param)
    return request.param


@pytest.fixture
def fast(monkeypatch):
    """Run the test only with the fast transport, for behavior that plain rospy does not have."""
    _set(monkeypatch, '')


@pytest.fixture
def name():
    """The name of a topic that no other test uses."""
    return '/topic_{}'.format(next(_numbers))


@pytest.fixture
def close_later():
    """A list of ends, closed after the test."""
    ends = []
    yield ends
    for end in ends:
        end.transport.close()
        end.sock.close()


@pytest.fixture
def subscribe(close_later):
    """A function that subscribes to a topic of this process, like another process would."""
    def connect(name, data_class):
        close_later.append(SubscriberEnd(name, data_class))
        return close_later[-1]
    return connect


@pytest.fixture
def publish_to(close_later):
    """A function that connects a publisher to a topic of this process."""
    def connect(name, data_class, **options):
        close_later.append(PublisherEnd(name, data_class, **options))
        return close_later[-1]
    return connect
