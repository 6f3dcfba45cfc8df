"""Requests to a served application that are endless, slow or never sent, and floods."""
import asyncio
import collections
import contextlib
import socket
import time

import psutil
import pytest

from img_recog.nodes.web import http_protocol
from img_recog.nodes.web.authentication import Authentication
from img_recog.nodes.web.server import Server, listen
from img_recog_testing import connecting
from img_recog_testing.connecting import is_closed
from img_recog_testing.waiting import DEADLINE_S, wait_for

TOKEN = b'Origin: http://x\r\nCookie: img_recog_1=t\r\n'
REQUEST = b'GET / HTTP/1.1\r\nHost: x\r\n' + TOKEN
UPGRADE = (b'GET /%s HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n' + TOKEN
           + b'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n')
MESSAGE, PING = b'\x81\x82' + bytes(4) + b'42', b'\x89\xfd' + bytes(129)
sessions, taken = set(), collections.Counter()


async def serve_web_socket(scope, receive, send):
    """Send without end at /endless; else take 100 messages a second."""
    await send({'type': 'websocket.accept'})
    with contextlib.suppress(OSError):      # of uvicorn: the visitor is gone
        while scope['path'] == '/endless':
            await send({'type': 'websocket.send', 'bytes': bytes(65536)})
            await asyncio.sleep(0)
    while (await receive())['type'] != 'websocket.disconnect':
        taken[receive] += 1
        await asyncio.sleep(0.01)


async def app(scope, receive, send):
    """Answer each request with `fine`."""
    if scope['type'] == 'websocket':
        sessions.add(receive)
        try:
            await serve_web_socket(scope, receive, send)
        finally:
            sessions.discard(receive)
        return
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
    sock, failures = listen('127.0.0.1', 28080), []
    server = Server(Authentication(app, 't', 1, failures.append), sock, failures.append)
    with connecting.connections(sock.getsockname()) as connect:
        yield connect
    wait_for(lambda: not sessions, lambda: 'the end of {} sessions'.format(len(sessions)))
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


def connections(port):
    """Return the connections to a server in this process at its end."""
    return [each for each in psutil.Process().connections('tcp')
            if each.laddr.port == port and each.status != psutil.CONN_LISTEN]


def flood(sock, piece, size):
    """Send up to `size` bytes, until the other end closes the connection or takes no more."""
    sock.settimeout(0.5)
    try:
        for _ in range(size // len(piece)):
            sock.sendall(piece)
    except socket.timeout:
        pass


def test_what_a_flood_has_sent_ends_with_its_connection(connect):
    for _ in range(8):
        sock = connect(UPGRADE % b'')
        port = sock.getpeername()[1]
        sock.recv(1000)         # with something unread, closing would discard what is sent
        flood(sock, 1000 * MESSAGE, 2000000)
        sock.close()
    wait_for(lambda: not sessions, lambda: '{} sessions'.format(len(sessions)))
    wait_for(lambda: not connections(port), lambda: connections(port))
    assert max(taken.values()) < 500


def test_a_flood_of_pings_is_ended(connect):
    sock = connect(UPGRADE % b'')
    with pytest.raises(ConnectionError):
        flood(sock, 100 * PING, 50000000)


def test_who_does_not_read_is_closed_and_who_reads_slowly_is_not(connect, monkeypatch):
    monkeypatch.setattr(http_protocol, '_TIME_LIMIT_S', 0.5)
    silent, slow = (connect(UPGRADE % b'endless') for _ in range(2))
    wait_for(lambda: len(sessions) == 2, lambda: len(sessions))
    end = time.monotonic() + DEADLINE_S
    while len(sessions) == 2 and time.monotonic() < end:
        assert slow.recv(65536)
    assert len(sessions) == 1
    for _ in range(200):
        assert slow.recv(65536)
    silent.close()
