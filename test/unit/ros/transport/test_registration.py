"""Calls to the master: registering again, and no wait for a silent master at the end."""
import os
import socket
import threading
import time

import pytest
import rospy
from rospy.impl import registration as rospy_registration
from sensor_msgs.msg import Image
from std_msgs.msg import String

from img_recog.ros.transport import registration
from img_recog.ros.transport.switch import VARIABLE
from img_recog_helpers.waiting import wait_for


@pytest.fixture
def silent(monkeypatch):
    """The proxy of a master that accepts connections and never answers."""
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(registration.MasterConnection, 'is_ending', threading.Event())
    monkeypatch.setattr(rospy.core, '_xmlrpc_cache', {})
    with socket.socket() as server:
        server.bind(('127.0.0.1', 0))
        server.listen(5)
        uri = 'http://127.0.0.1:{}'.format(server.getsockname()[1])
        monkeypatch.setenv('ROS_MASTER_URI', uri)
        registration.limit_calls()
        yield rospy.core.xmlrpcapi(uri)


def call_in_thread(master):
    """Call the master; return the thread, and the list for its error."""
    errors = []

    def call():
        try:
            master.getPid('/node')
        except OSError as error:
            errors.append(error)
    thread = threading.Thread(target=call, daemon=True)
    thread.start()
    return thread, errors


def test_a_call_that_waits_for_an_answer_is_interrupted(silent):
    thread, errors = call_in_thread(silent)
    wait_for(lambda: len(registration.MasterConnection.all) > 0, 'the connection')
    assert thread.is_alive()
    registration.end_calls()
    thread.join(30.0)
    assert not thread.is_alive() and isinstance(errors[0], ConnectionRefusedError)
    assert errors[0].args[0] == 111         # rospy's cleanup expects a number and a text


def test_a_call_during_the_shutdown_does_not_wait(silent):
    registration.end_calls()
    began_s = time.monotonic()
    with pytest.raises(ConnectionRefusedError):
        silent.getPid('/node')
    assert time.monotonic() - began_s < 30.0


def test_a_call_to_a_host_that_drops_packets_is_interrupted(silent):
    host, port = os.environ['ROS_MASTER_URI'][len('http://'):].split(':')
    waiting = []
    for _ in range(20):             # until the queue of the listening socket is full
        waiting.append(socket.socket())
        waiting[-1].setblocking(False)
        waiting[-1].connect_ex((host, int(port)))
    thread, errors = call_in_thread(silent)
    registration.end_calls()
    thread.join(30.0)
    for each in waiting:
        each.close()
    assert not thread.is_alive() and isinstance(errors[0], ConnectionRefusedError)


def test_with_plain_rospy_calls_are_not_changed(monkeypatch):
    monkeypatch.setattr(rospy.core, '_xmlrpc_cache', {})
    for value in ('1', 'registration'):
        monkeypatch.setenv(VARIABLE, value)
        registration.limit_calls()
        assert not registration.is_watched() and rospy.core._xmlrpc_cache == {}


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
    assert registration.register_again(call) == registration.Registered(topics=2, services=1)
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
