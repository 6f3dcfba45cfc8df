"""The internals of rospy that ros/transport uses exist and behave as expected.

After an update of rospy, the tests of the changed names fail.
"""
import inspect
import io
import socket
import struct
import threading
import xmlrpc.client

import genpy
import pytest
import rospy
from rosgraph import roslogging
from rospy.impl import registration, rosout, simtime
from rospy.impl.tcpros_base import TCPROSServer, TCPROSTransport
from rospy.impl.tcpros_pubsub import QueuedConnection, TCPROSHandler, TCPROSPub, TCPROSSub
from rospy.impl.tcpros_service import service_connection_handler
from sensor_msgs.msg import Image
from std_msgs.msg import String

from img_recog_testing.tcpros import packet

pytestmark = pytest.mark.usefixtures('fast')


def parameters(function):
    return list(inspect.signature(function).parameters)


@pytest.fixture
def publication(name):
    """The impl of a Publisher without a queue."""
    with pytest.warns(SyntaxWarning):
        return rospy.Publisher(name, String, queue_size=None).impl


@pytest.fixture
def subscription(name):
    """The impl of a Subscriber."""
    return rospy.Subscriber(name, Image, queue_size=1, tcp_nodelay=True).impl


def test_signatures():
    impl, handler = rospy.topics._PublisherImpl, rospy.topics._SubscriberImpl
    assert parameters(impl.add_connection) == ['self', 'c']
    assert parameters(handler.add_connection) == ['self', 'c']
    assert parameters(handler.add_callback) == ['self', 'cb', 'cb_args']
    assert parameters(handler._invoke_callback) == ['self', 'msg', 'cb', 'cb_args']
    assert parameters(TCPROSTransport.write_data) == ['self', 'data']
    assert parameters(TCPROSTransport.close) == ['self']
    assert parameters(TCPROSSub.read_messages) == ['self', 'b', 'msg_queue', 'sock']
    assert parameters(rospy.rostime._set_rostime) == ['t']
    assert {'name', 'data_class', 'latch', 'queue_size'} <= set(parameters(rospy.Publisher))


def test_a_publication(publication):
    assert publication.connections == [] and publication.seq == 0
    assert isinstance(publication.c_lock, type(threading.RLock()))
    assert 'add_connection' not in vars(publication)


def test_without_a_queue_a_publication_has_plain_connections(publication, name, subscribe):
    end = subscribe(name, String)
    assert publication.connections == [end.transport]
    assert isinstance(end.transport.socket, socket.socket)


def test_the_list_of_connections_is_replaced_and_never_changed(publication, name, subscribe):
    before = publication.connections
    end = subscribe(name, String)
    during = publication.connections
    end.transport.close()
    assert before == [] and during == [end.transport] and publication.connections == []


def test_with_a_queue_a_publication_has_queued_connections(name, subscribe):
    impl = rospy.Publisher(name, String, queue_size=1).impl
    subscribe(name, String)
    connection, = impl.connections
    assert isinstance(connection, QueuedConnection)
    assert not isinstance(connection, TCPROSTransport)


def test_data_is_copied_when_write_data_returns(publication, name, subscribe):
    end = subscribe(name, String)
    data = bytearray(packet(String('x')))
    end.transport.write_data(data)
    data[:] = bytes(len(data))
    assert end.receive() == packet(String('x'))


def test_write_data_to_a_closed_subscriber_raises_and_closes(publication, name, subscribe):
    end = subscribe(name, String)
    end.sock.close()
    with pytest.raises(Exception):
        end.transport.write_data(b'data')
    assert end.transport.done and end.transport.socket is None


def test_publish_calls_write_data_of_the_connection_and_closes_it_after_an_error(
        publication, name, subscribe):
    calls, failing, other = [], *(subscribe(name, String).transport for _ in range(2))

    def fail(data):
        raise BrokenPipeError('closed')
    failing.write_data, other.write_data = fail, calls.append
    publication.publish(String('x'))
    assert calls == [packet(String('x'))] and publication.connections == [other]
    assert failing.done and failing.socket is None


def test_a_connection_counts_its_messages(publication, name, subscribe):
    transport = subscribe(name, String).transport
    assert (transport.stat_bytes, transport.stat_num_msg) == (0, 0)
    transport.write_data(b'1234')
    assert (transport.stat_bytes, transport.stat_num_msg) == (4, 1)


def test_add_connection_of_a_latched_topic_sends_by_write_data(publication, name):
    publication.enable_latch()
    publication.publish(String('x'))
    written = []
    sock, theirs = socket.socketpair()
    with sock, theirs:
        transport = TCPROSTransport(TCPROSPub(name, String), name)
        transport.set_socket(theirs, '/subscriber')
        transport.write_data = written.append
        assert publication.add_connection(transport) is True
    assert len(written) == 1


def test_rospy_adds_subscribers_by_add_connection_of_the_topic():
    source = inspect.getsource(TCPROSHandler.topic_connection_handler)
    assert source.count('topic.add_connection(transport)') == 1


def test_publish_counts_messages(publication, name, subscribe):
    end = subscribe(name, String)
    publication.publish(String('x'))
    assert publication.seq == 1 and end.receive() == packet(String('x'))


def test_a_subscription(subscription):
    assert subscription.connections == [] and subscription.callbacks == []
    assert isinstance(subscription.c_lock, type(threading.RLock()))
    assert subscription.statistics_logger is None
    assert 'add_connection' not in vars(subscription)


def test_a_connection_of_a_subscriber(subscription, name, publish_to):
    transport = publish_to(name, Image, begin=False).transport
    assert isinstance(transport.protocol, TCPROSSub)
    assert transport.protocol.buff_size == rospy.topics.DEFAULT_BUFF_SIZE
    assert transport.endpoint_id.startswith('/publisher')
    assert transport.is_latched is False and transport.stat_num_msg == 0
    transport.close()
    assert transport.protocol is None


def test_rospy_calls_add_connection_of_the_topic():
    source = inspect.getsource(TCPROSHandler.create_transport)
    assert 'sub.add_connection(conn)' in source
    assert source.index('sub.add_connection(conn)') < source.index('t.start()')


def test_rospy_calls_read_messages_of_the_protocol(subscription, name, publish_to):
    """The buffer has at least four bytes; rospy calls again until there is a message."""
    publisher = publish_to(name, Image, begin=False)
    calls, protocol = [], publisher.transport.protocol

    def read_messages(buffer, messages, sock):
        calls.append((buffer.tell(), sock))
        assert bytes(buffer.getbuffer()[:4]) == b'head'
        buffer.seek(0)
        if len(calls) == 3:
            messages.append(Image())
    protocol.read_messages, protocol.buff_size = read_messages, 4
    socket_of_rospy = publisher.transport.socket
    publisher.sock.sendall(b'headheadhead')
    message, = publisher.transport.receive_once()
    assert calls == [(4, socket_of_rospy)] * 3
    assert publisher.transport.stat_num_msg == 1
    assert message._connection_header is publisher.transport.header


def test_read_messages_of_rospy_takes_all_messages_in_the_buffer(subscription, name, publish_to):
    protocol = publish_to(name, Image, begin=False).transport.protocol
    buffer, messages = io.BytesIO(), []
    buffer.write(packet(Image(height=7)) + struct.pack('<I', 1000) + b'begun')
    protocol.read_messages(buffer, messages, None)
    assert [msg.height for msg in messages] == [7]
    assert buffer.tell() == 4 + len(b'begun')


def test_the_protocol_of_a_publisher_can_be_made_from_topic_and_type():
    assert TCPROSPub('/topic', String).buff_size > 0


def test_a_callback_that_fails_is_logged(subscription, monkeypatch):
    lines = []
    monkeypatch.setattr(rospy.topics, 'logerr', lines.append)
    subscription._invoke_callback(Image(), lambda msg: 1 / 0, None)
    assert len(lines) == 1 and 'ZeroDivisionError' in lines[0]


def test_rosout_uses_publisher_and_handler_of_its_module(monkeypatch):
    made = []
    monkeypatch.setattr(rosout, 'Publisher', lambda *args, **kwargs: made.append((args, kwargs)))
    monkeypatch.setattr(rosout, '_rosout_pub', None)
    assert rosout.init_rosout()
    assert made == [(('/rosout', rosout.Log), {'latch': True, 'queue_size': 100})]
    assert 'RosOutHandler()' in inspect.getsource(rosout.load_rosout_handlers)
    assert inspect.isclass(rosout.RosOutHandler)


def test_the_server_of_incoming_connections():
    server = TCPROSServer()
    assert parameters(TCPROSServer._tcp_server_callback) == ['self', 'sock', 'client_addr']
    for handler in (server.topic_connection_handler, server.service_connection_handler,
                    service_connection_handler):
        assert parameters(handler) == ['sock', 'client_addr', 'header']
    assert 'TCPServer(self._tcp_server_callback' in inspect.getsource(TCPROSServer.start_server)


def test_rospy_configures_logging_by_the_function_of_rosgraph():
    assert parameters(roslogging.configure_logging) == ['logname', 'level', 'filename', 'env']
    assert 'rosgraph.roslogging.configure_logging(' in inspect.getsource(
        rospy.core.configure_logging)
    assert parameters(roslogging.makedirs_with_parent_perms) == ['p']


def test_the_topics_of_a_node(publication, name):
    assert name in registration.get_topic_manager().get_topics()


def test_calls_to_the_master(monkeypatch):
    proxy = rospy.core._LockedServerProxy('http://127.0.0.1:1')
    assert isinstance(proxy, xmlrpc.client.ServerProxy)
    assert isinstance(rospy.core._xmlrpc_lock, type(threading.Lock()))
    monkeypatch.setitem(rospy.core._xmlrpc_cache, 'http://127.0.0.1:1', proxy)
    assert rospy.core.xmlrpcapi('http://127.0.0.1:1') is proxy


def test_registrations_of_a_node(publication, subscription, name):
    assert registration.get_registration_listeners().listeners == []
    manager = registration.RegManager
    assert issubclass(manager, registration.RegistrationListener)
    assert parameters(manager.publisher_update) == ['self', 'resolved_name', 'uris']
    assert parameters(manager._connect_topic_thread) == ['self', 'topic', 'uri']
    source = inspect.getsource(manager._connect_topic_thread)
    assert 'self.handler._connect_topic(topic, uri)' in source and 'except Exception' in source
    topics = registration.get_topic_manager()
    assert topics.get_subscriber_impl(name).connections == []
    assert [name, String._type] in map(list, topics.get_publications())
    assert [name, Image._type] in map(list, topics.get_subscriptions())
    assert registration.get_service_manager().get_services() == []


def test_a_node_is_unregistered_by_the_proxy_and_survives_a_refused_connection():
    source = inspect.getsource(registration.RegManager.cleanup)
    assert 'master = xmlrpcapi(self.master_uri)' in source
    assert 'errno.ECONNREFUSED' in source


def test_the_publications_of_a_node(publication, name, subscribe):
    assert registration.get_topic_manager().pubs[name] is publication
    assert publication.resolved_name == name
    end = subscribe(name, String)
    assert publication.connections[0].endpoint_id == end.transport.endpoint_id


def test_the_time_of_a_node(monkeypatch):
    monkeypatch.setattr(rospy.rostime, '_rostime_initialized', True)
    try:
        rospy.rostime._set_rostime(genpy.Time(5, 0))
        assert rospy.Time.now() == genpy.Time(5, 0) and not rospy.rostime.is_wallclock()
    finally:
        rospy.rostime.switch_to_wallclock()
    assert simtime._set_rostime is rospy.rostime._set_rostime
    assert isinstance(rospy.rostime._rostime_cond, threading.Condition)
