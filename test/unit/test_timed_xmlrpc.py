"""Answers of a master or node that make no sense: each is one of the errors callers expect."""
import socket
import threading

import pytest

from img_recog import timed_xmlrpc


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
