"""What ros/transport expects of rospy and the other tests of this folder do not run.

After an update of rospy, the tests of what has changed fail.
"""
import inspect

import pytest
import rospy
from rosgraph import roslogging
from rospy.impl import registration, rosout
from rospy.impl.tcpros_pubsub import TCPROSHandler
from std_msgs.msg import String

from img_recog.ros.parameters import LOG_TOPICS_ARE_LEFT_OUT

pytestmark = pytest.mark.usefixtures('fast')


def parameters(function):
    return list(inspect.signature(function).parameters)


def test_the_list_of_connections_is_replaced_and_never_changed(name, subscribe):
    with pytest.warns(SyntaxWarning):
        publication = rospy.Publisher(name, String, queue_size=None).impl
    before = publication.connections
    end = subscribe(name, String)
    during = publication.connections
    end.transport.close()
    assert before == [] and during == [end.transport] and publication.connections == []


def test_connections_are_added_by_a_method_of_the_topic():
    source = inspect.getsource(TCPROSHandler.topic_connection_handler)
    assert source.count('topic.add_connection(transport)') == 1
    source = inspect.getsource(TCPROSHandler.create_transport)
    assert source.index('sub.add_connection(conn)') < source.index('t.start()')


def test_rosout_uses_the_publisher_of_its_module(monkeypatch):
    made = []
    monkeypatch.setattr(rosout, 'Publisher', lambda *args, **kwargs: made.append((args, kwargs)))
    monkeypatch.setattr(rosout, '_rosout_pub', None)
    assert rosout.init_rosout()
    assert made == [(('/rosout', rosout.Log), {'latch': True, 'queue_size': 100})]
    # it asks the master for each line, until the cache has a value that is no namespace
    source = inspect.getsource(rosout._rosout)
    assert 'rospy.get_param_cached("{}", False)'.format(LOG_TOPICS_ARE_LEFT_OUT) in source


def test_rospy_configures_logging_by_the_function_of_rosgraph():
    assert parameters(roslogging.configure_logging) == ['logname', 'level', 'filename', 'env']
    assert 'rosgraph.roslogging.configure_logging(' in inspect.getsource(
        rospy.core.configure_logging)


def test_registrations_of_a_node():
    manager = registration.RegManager
    assert issubclass(manager, registration.RegistrationListener)
    assert parameters(manager.publisher_update) == ['self', 'resolved_name', 'uris']
