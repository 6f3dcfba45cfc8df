"""Log lines on /rosout: the publisher, and the parameter that is read once."""
import pytest
import rospy
from rospy.impl import paramserver
from rospy.impl import rosout as rospy_rosout

from img_recog.ros.transport import rosout
from img_recog.ros.transport.direct_publisher import DirectPublisher


@pytest.fixture
def init_node(monkeypatch):
    """A function that calls rosout.init_node with a master that answers a call as given."""
    for name in ('Publisher', '_rosout_pub'):
        monkeypatch.setattr(rospy_rosout, name, getattr(rospy_rosout, name))
    monkeypatch.setattr(rospy, 'init_node', lambda *args, **options: rospy_rosout.init_rosout())
    cache = paramserver.get_param_server_cache()
    monkeypatch.setattr(cache, 'd', None)
    monkeypatch.setattr(cache, 'get', cache.get)

    def call(get_param):
        monkeypatch.setattr(rospy, 'get_param', get_param)
        rosout.init_node('node')
    return call


def test_the_publisher_is_latched(way, init_node):
    init_node(lambda name, default: default)
    assert rospy.topics.get_topic_manager().get_publisher_impl('/rosout').is_latch
    assert isinstance(rospy_rosout._rosout_pub, DirectPublisher) == (way == '')


@pytest.mark.parametrize('value', [True, False])
def test_whether_topics_are_named_is_asked_once(fast, init_node, value):
    init_node(lambda name, default: value)
    assert rospy.get_param_cached('/rosout_disable_topics_generation') is value


def test_other_parameters_are_asked_of_the_master(fast, init_node):
    init_node(lambda name, default: True)
    for name in '/', '/other':
        with pytest.raises(KeyError):
            paramserver.get_param_server_cache().get(name)


def refuse(*_):
    raise ConnectionRefusedError('no master')


def test_without_a_master_the_node_starts_and_rospy_asks_later(fast, init_node):
    init_node(refuse)
    with pytest.raises(KeyError):
        paramserver.get_param_server_cache().get('/rosout_disable_topics_generation')
