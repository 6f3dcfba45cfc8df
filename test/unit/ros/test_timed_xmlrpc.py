"""Calls of a master, and answers that make no sense: each is one of the errors callers expect."""
import socket
import threading
import xmlrpc.client

import pytest

from img_recog.ros import timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master
from img_recog_helpers.waiting import DEADLINE_S
from img_recog_helpers.xmlrpc_server import XmlRpcServer


@pytest.fixture
def answered():
    """A function that calls a server whose answer has this body."""
    with socket.socket() as server:
        server.bind(('127.0.0.1', 0))
        server.listen()

        def serve(body):
            connection, _ = server.accept()
            with connection:
                connection.recv(65536)
                connection.sendall('HTTP/1.0 200 OK\r\nContent-Type: text/html\r\n'
                                   'Content-Length: {}\r\n\r\n'.format(len(body)).encode() + body)

        def call(body):
            thread = threading.Thread(target=serve, args=(body,))
            thread.start()
            with timed_xmlrpc.server('http://127.0.0.1:{}'.format(server.getsockname()[1])) as it:
                try:
                    return it.getPid('/test')
                finally:
                    thread.join()
        yield call


def test_an_answer_is_returned(answered):
    assert answered(b'<methodResponse><params><param><value><int>1</int></value></param></params>'
                    b'</methodResponse>') == 1


# a page of another program on this port; bytes that are no text; half of an answer
@pytest.mark.parametrize('body', [
    b'<!DOCTYPE html><html><br></html>', b'', b'\xff\xfe\x00',
    b'<methodResponse><params><param><value><int>x</int></value></param></params>'
    b'</methodResponse>', b'<methodResponse><params>'])
def test_no_answer_of_a_node(answered, body):
    with pytest.raises(timed_xmlrpc.ERRORS):
        answered(body)


@pytest.fixture
def parameters():
    """The parameters of a master, and its address."""
    values = {'/use_sim_time': True, '/robot/robot_description': '<robot/>'}

    def answer(method, node, name, *value):
        assert node == '/node'
        if method == 'hasParam':
            return 1, '', name in values
        if method == 'searchParam':
            name, found = '/robot/' + name, '/robot/' + name
        elif method == 'getParam':
            found = values.get(name)
        elif method == 'setParam':
            values[name], found = *value, 0
        return (1, '', found) if name in values else (-1, 'there is none', 0)
    server = XmlRpcServer(dispatch=answer)
    yield values, server.uri
    server.stop()


def test_the_parameters_of_a_master(parameters):
    values, uri = parameters
    with Master(uri, '/node', DEADLINE_S) as master:
        assert master.call('getParam', '/use_sim_time') is True
        with pytest.raises(xmlrpc.client.Error, match='getParam: there is none'):
            master.call('getParam', '/none')
        assert master.ask('getParam', '/none') is None
        assert master.shared_parameters() == values
        # an integer of more than 32 bits cannot be transmitted
        assert master.set_missing({'/use_sim_time': False, '/own': 5, '/large': 1 << 40,
                                   '/nothing': None}) == 2
        assert values == {'/use_sim_time': True, '/robot/robot_description': '<robot/>',
                          '/own': 5, '/nothing': None}
        values.clear()
        assert master.shared_parameters() == {}


def test_what_answers_nothing_or_no_http_is_an_error_of_the_system():
    with socket.socket() as server:
        server.bind(('127.0.0.1', 0))
        server.listen()
        uri = 'http://127.0.0.1:{}'.format(server.getsockname()[1])
        with Master(uri, '/node', 0.02) as master, pytest.raises(OSError):
            master.ask('getParam', '/x')
        server.accept()[0].close()

        def serve():
            with server.accept()[0] as connection:
                connection.recv(65536)
                connection.sendall(b'no HTTP\r\n')
        thread = threading.Thread(target=serve)
        thread.start()
        with Master(uri, '/node', DEADLINE_S) as master, pytest.raises(OSError, match='no HTTP'):
            master.ask('getParam', '/x')
        thread.join()
