"""Registering all topics and services of a node with another master."""
import pytest
import rospy
from rospy.impl import registration as rospy_registration
from sensor_msgs.msg import Image
from std_msgs.msg import String

from img_recog.ros.transport import registration


@pytest.mark.usefixtures('fast')
def test_all_topics_and_services_are_registered_again(name, monkeypatch):
    calls, updates = [], []
    manager = rospy_registration.RegManager.__new__(rospy_registration.RegManager)
    manager.publisher_update = lambda topic, uris: updates.append((topic, uris))
    monkeypatch.setattr(rospy_registration.get_registration_listeners(), 'listeners', [manager])
    monkeypatch.setattr(rospy, 'get_node_uri', lambda: 'http://node')
    monkeypatch.setattr(rospy_registration.get_service_manager(), 'get_services',
                        lambda: [('/service', 'rosrpc://node')])
    impl = rospy_registration.get_topic_manager()
    monkeypatch.setattr(impl, 'get_publications', lambda: [('/a' + name, String._type)])
    monkeypatch.setattr(impl, 'get_subscriptions', lambda: [('/b' + name, Image._type)])

    def call(*words):
        calls.append(words)
        return ['http://publisher'] if words[0] == 'registerSubscriber' else 1
    assert registration.register_again(call) == (2, 1)
    assert calls == [('registerPublisher', '/a' + name, String._type, 'http://node'),
                     ('registerSubscriber', '/b' + name, Image._type, 'http://node'),
                     ('registerService', '/service', 'rosrpc://node', 'http://node')]
    assert updates == [('/b' + name, ['http://publisher'])]


@pytest.mark.usefixtures('fast')
def test_an_error_ends_the_registration(name, monkeypatch):
    monkeypatch.setattr(rospy, 'get_node_uri', lambda: 'http://node')
    monkeypatch.setattr(rospy_registration.get_topic_manager(), 'get_publications',
                        lambda: [(name, String._type)])

    def call(*words):
        raise ConnectionRefusedError
    with pytest.raises(ConnectionRefusedError):
        registration.register_again(call)
