"""Requests to a served application that are endless, slow or never sent."""
import socket
import time

import pytest

from img_recog.nodes.web import http_protocol
from img_recog.nodes.web.server import Server, listen
from img_recog_testing.waiting import DEADLINE_S

REQUEST = b'GET / HTTP/1.1\r\nHost: x\r\n'


async def app(scope, receive, send):
    """Answer each request with `fine`."""
    if scope['type'] == 'lifespan':
        for name in ('startup', 'shutdown'):
            await receive()
            await send({'type': 'lifespan.{}.complete'.format(name)})
        return
    await send({'type': 'http.response.start', 'status': 200, 'headers': []})
    await send({'type': 'http.response.body', 'body': b'fine'})


@pytest.fixture
def connect():
    """A function that connects to the server and sends data."""
    sock, failures, socks = listen('127.0.0.1', 28080), [], []
    server = Server(app, sock, failures.append)

    def call(data=b''):
        socks.append(socket.create_connection(sock.getsockname(), DEADLINE_S))
        socks[-1].sendall(data)
        return socks[-1]
    yield call
    for each in socks:
        each.close()
    server.close()
    assert failures == []


def is_answered(sock):
    """Send a complete request; return if the answer of `app` comes."""
    sock.sendall(REQUEST + b'\r\n')
    answer = b''
    while b'fine' not in answer:
        piece = sock.recv(1000)
        if not piece:
            return False
        answer += piece
    return True


def is_closed(sock):
    """Wait until the other end closes the connection."""
    try:
        return sock.recv(100) == b''
    except ConnectionError:
        return True


@pytest.mark.parametrize('begin, piece', [
    (REQUEST + b'a: ', 65536 * b'b'), (REQUEST, 4096 * b'a: bcdefghijkl\r\n'),
    (b'GET /', 65536 * b'b'), (b'', 32768 * b'\r\n'),
    (REQUEST + b'Upgrade: websocket\r\nConnection: Upgrade\r\na: ', 65536 * b'b')],
    ids=['value', 'headers', 'path', 'lines', 'websocket'])
def test_an_endless_header_is_refused(connect, begin, piece):
    sock = connect(begin)
    with pytest.raises(ConnectionError):
        for _ in range(1000):
            sock.sendall(piece)
    assert is_answered(connect())


def test_silent_and_slow_connections_are_closed_and_others_are_served(connect, monkeypatch):
    monkeypatch.setattr(http_protocol, '_TIME_LIMIT_S', 0.5)
    socks = [connect() for _ in range(200)] + [connect(REQUEST)]
    begin_s = time.monotonic()
    kept = connect()
    assert is_answered(kept)
    assert time.monotonic() - begin_s < DEADLINE_S / 2
    assert all(map(is_closed, socks))
    assert is_answered(kept)
