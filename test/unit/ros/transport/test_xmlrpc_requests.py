"""Connections to the XML-RPC server of rospy that are silent, slow, endless or packed."""
import threading
import time
import urllib.error
import urllib.request
import xmlrpc.client

import pytest
from rosgraph import xmlrpc as ros_xmlrpc

from img_recog.ros.transport import xmlrpc_requests
from img_recog_testing.connecting import connections
from img_recog_testing.waiting import DEADLINE_S, wait_for

CALL = xmlrpc.client.dumps((1,), 'add').encode()
HEADER = b'POST /RPC2 HTTP/1.1\r\nContent-Length: %d\r\n\r\n'


@pytest.fixture
def server(monkeypatch):
    """A server that answers `add`, with a short limit of the time."""
    monkeypatch.setattr(xmlrpc_requests, '_TIME_LIMIT_S', 0.5)
    for owner, name in ((ros_xmlrpc, 'SilenceableXMLRPCRequestHandler'),
                        (ros_xmlrpc.ThreadingXMLRPCServer, 'get_request')):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    xmlrpc_requests.install()
    server = ros_xmlrpc.ThreadingXMLRPCServer(('127.0.0.1', 0), 0)
    server.register_function(lambda number: number + 1, 'add')
    thread = threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True)
    thread.start()
    yield server
    server.shutdown()
    server.server_close()


@pytest.fixture
def connect(server):
    """A function that connects and sends data."""
    with connections(server.server_address) as connect:
        yield connect


def drip(sock, data, pause_s):
    """Send data in small pieces until the other end closes; return how much was sent."""
    sent, end = 0, time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        try:
            sock.sendall(data)
        except OSError:
            return sent
        sent += len(data)
        time.sleep(pause_s)
    raise AssertionError('not closed after {} bytes'.format(sent))


def is_closed(sock):
    """Wait for the end of a connection."""
    try:
        while sock.recv(4096):
            pass
    except ConnectionResetError:
        pass
    return True


@pytest.mark.parametrize('data', [b'', b'POST', HEADER % 100, HEADER % len(CALL) + CALL[:-1],
                                  HEADER % len(CALL) + CALL], ids=repr)
def test_a_connection_that_says_nothing_more_is_closed_and_its_thread_ends(connect, data):
    before = threading.active_count()
    assert is_closed(connect(data))
    wait_for(lambda: threading.active_count() <= before, 'the end of the thread')


@pytest.mark.parametrize('start, piece', [(b'POST', b'x'), (HEADER % (1 << 17), b' '),
                                          (b'POST / HTTP/1.1\r\n', b'a: b\r\n')], ids=repr)
def test_the_limit_is_for_the_whole_request(connect, start, piece):
    assert drip(connect(start), piece, 0.05) < 1000


def test_an_endless_request_ends_at_256_kb(connect, monkeypatch):
    monkeypatch.setattr(xmlrpc_requests, '_TIME_LIMIT_S', 10 * DEADLINE_S)
    assert drip(connect(HEADER % (1 << 40)), bytes(1 << 16), 0) < 24 << 20      # with buffers


def test_calls_are_answered_on_one_connection_also_after_a_pause(server, connect):
    silent = [connect() for _ in range(20)]
    with xmlrpc.client.ServerProxy('http://{}:{}'.format(*server.server_address)) as proxy:
        for number in range(5):
            assert proxy.add(number) == number + 1
        assert all(map(is_closed, silent))
        assert proxy.add(7) == 8


def test_a_packed_request_is_not_unpacked(server):
    class Packed(xmlrpc.client.Transport):
        encode_threshold = 1
    with xmlrpc.client.ServerProxy('http://{}:{}'.format(*server.server_address),
                                   Packed()) as proxy, pytest.raises(xmlrpc.client.Fault):
        proxy.add(1)


@pytest.mark.parametrize('encoding', ['utf-8', 'utf-16'])
def test_entities_are_refused(server, encoding):
    text = CALL.decode().replace("?>", '?><!DOCTYPE a [<!ENTITY b "1">]>').replace('1<', '&b;<')
    request = urllib.request.Request('http://{}:{}'.format(*server.server_address),
                                     text.encode(encoding), {'Content-Type': 'text/xml'})
    with pytest.raises(urllib.error.HTTPError, match='400'):
        urllib.request.urlopen(request, timeout=DEADLINE_S)
