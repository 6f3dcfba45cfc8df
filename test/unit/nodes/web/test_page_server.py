"""The address of the page, and the server."""
import ast
import asyncio
import contextlib
import gc
import logging
import socket
import sys
import threading
import time
import urllib.request

import pytest

from img_recog.errors import UserError
from img_recog.nodes.web import connections, page
from img_recog.nodes.web.connections import admit
from img_recog.nodes.web.page import Server, address, listen
from img_recog_helpers.waiting import DEADLINE_S, wait_for


def free_port():
    """Return a port that nobody listens at, with others after it."""
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return min(probe.getsockname()[1], 65500)


@contextlib.contextmanager
def open_connections(address):
    """Yield a function that connects to a server and sends data; close all at the end."""
    with contextlib.ExitStack() as socks:
        def connect(data=b''):
            sock = socks.enter_context(socket.create_connection(address, DEADLINE_S))
            sock.sendall(data)
            return sock
        yield connect


def is_closed(sock):
    """Wait until the other end closes the connection, without having sent anything."""
    try:
        return sock.recv(100) == b''
    except ConnectionError:
        return True


def test_the_next_free_port_is_taken():
    with listen('127.0.0.1', free_port()) as first:
        port = first.getsockname()[1]
        with listen('127.0.0.1', port) as second:
            assert port < second.getsockname()[1] <= port + 10
            with listen('127.0.0.1', port) as third:
                assert third.getsockname()[1] > second.getsockname()[1]


@pytest.mark.parametrize('host', ['203.0.113.7', 'no such host.invalid'])
def test_an_address_of_another_computer(host):
    with pytest.raises(UserError, match='cannot serve the page at .*set web_host'):
        listen(host, 18200)


def test_all_ports_taken(monkeypatch):
    monkeypatch.setattr(page, 'PORTS', 1)
    with listen('127.0.0.1', 0) as taken:
        with pytest.raises(UserError, match='ports .*: Address already in use'):
            listen('127.0.0.1', taken.getsockname()[1])


def test_a_port_that_only_root_may_use(monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, 'Permission denied')
    monkeypatch.setattr(page.socket, 'create_server', refuse)
    with pytest.raises(UserError, match='ports 80 to 90: Permission denied; set web_port to a '
                       'port from 1024 on'):
        listen('127.0.0.1', 80)


@pytest.mark.parametrize('host, port, shown', [
    ('127.0.0.1', 8080, 'http://localhost:8080/?token=t'),
    ('::1', 8081, 'http://localhost:8081/?token=t'),
    ('192.0.2.5', 8080, 'http://192.0.2.5:8080/?token=t'),
    ('2001:db8::1', 8080, 'http://[2001:db8::1]:8080/?token=t'),
    ('0.0.0.0', 8080, 'http://{}:8080/?token=t'.format(socket.gethostname()))])
def test_the_address_for_a_browser(host, port, shown):
    class Sock:
        def getsockname(self):
            return host, port
    assert address(Sock(), 't') == shown


def test_the_address_of_a_container_is_that_of_its_host(monkeypatch):
    monkeypatch.setenv('IMG_RECOG_PAGE_HOST', 'localhost')
    with listen('0.0.0.0', 8080) as sock:
        assert address(sock, 't') == 'http://localhost:{}/?token=t'.format(sock.getsockname()[1])
    with listen('127.0.0.2', 8080) as sock:
        assert address(sock, 't').startswith('http://127.0.0.2:')


def test_what_libraries_log_as_errors_is_reported(capfd):
    reported = []
    page.report_errors(reported.append)
    logger = logging.getLogger('engineio.server')
    try:
        raise ValueError('bad packet')
    except ValueError:
        logger.exception('post request handler error')
    logger.error('no %s', 'session')
    logger.info('connected')
    assert [str(error) for error in reported] == ['bad packet', 'engineio.server: no session']
    assert capfd.readouterr().err == ''


WEB_SOCKET = (b'GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n'
              b'Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n')


async def hello(scope, receive, send):
    if scope['type'] == 'lifespan':
        while True:
            message = await receive()
            await send({'type': message['type'] + '.complete'})
            if message['type'] == 'lifespan.shutdown':
                return
    if scope['type'] == 'websocket':
        await send({'type': 'websocket.accept'})
        while (await receive())['type'] != 'websocket.disconnect':
            pass
        return
    if scope['path'] == '/with-token':
        admit(scope)
    while scope['path'] == '/slow' and not Slow.go_on.is_set():
        await asyncio.sleep(0.01)
    await send({'type': 'http.response.start', 'status': 200, 'headers': []})
    await send({'type': 'http.response.body', 'body': b'hello'})


class Slow:
    """Responses to /slow wait for it."""

    go_on = threading.Event()


@pytest.fixture
def serve():
    """A function that starts a server; returns its address."""
    servers, failures = [], []

    def serve():
        sock = listen('127.0.0.1', free_port())
        servers.append(Server(hello, sock, failures.append))
        return sock.getsockname()
    yield serve
    for each in servers:
        each.close()
    assert failures == []


@pytest.mark.parametrize('begin, piece', [
    (b'GET / HTTP/1.1\r\na: ', 65536 * b'b'),
    (b'GET / HTTP/1.1\r\n', 4096 * b'a: bcdefghijkl\r\n'), (b'GET /', 65536 * b'b'),
    (WEB_SOCKET,
     b'\x81\xff' + bytes([0, 0, 0, 0, 0, 2, 0, 0]) + bytes(4) + 131072 * b'a')],
    ids=['value', 'headers', 'path', 'message'])
def test_what_is_endless_is_ended_and_others_are_served(serve, begin, piece):
    address_of = serve()
    with open_connections(address_of) as connect:
        with pytest.raises(ConnectionError):
            sock = connect(begin)
            for _ in range(1000):
                sock.sendall(piece)
        other = connect(b'GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n')
        with other.makefile('rb') as answer:
            assert b'hello' in answer.read()


REQUEST = b'GET /{} HTTP/1.1\r\nHost: x\r\n'


def request(path=''):
    return REQUEST.replace(b'{}', path.encode())


def read_response(sock, ending=b'hello\r\n0\r\n\r\n'):
    """Read until the end of a response."""
    received = b''
    while ending not in received:
        data = sock.recv(1000)
        assert data, received
        received += data


@pytest.mark.parametrize('piece', [b'', b'G', request(), request() + b'Connection: keep-alive'])
@pytest.mark.parametrize('path', ['', 'with-token'])
def test_an_unfinished_header_ends_a_connection(serve, monkeypatch, piece, path):
    monkeypatch.setattr(connections, 'HEADER_TIMEOUT_S', 0.3)
    with open_connections(serve()) as connect:
        assert is_closed(connect(piece))
        sock = connect(request(path) + b'\r\n')        # the second header is unfinished
        read_response(sock)
        with contextlib.suppress(ConnectionError):
            sock.sendall(piece)
        assert is_closed(sock)


def test_bytes_one_by_one_do_not_prolong_the_time_of_a_header(serve, monkeypatch):
    monkeypatch.setattr(connections, 'HEADER_TIMEOUT_S', 0.3)
    with open_connections(serve()) as connect:
        sock = connect(request())

        def is_ended():
            try:
                sock.sendall(b'a')
            except ConnectionError:
                return True
        wait_for(is_ended, 'the end of the connection')


def test_a_response_and_a_web_socket_may_take_longer_than_a_header(serve, monkeypatch):
    monkeypatch.setattr(connections, 'HEADER_TIMEOUT_S', 0.3)
    address_of = serve()
    with open_connections(address_of) as connect:
        slow = connect(request('slow') + b'\r\n')
        socket_of_web = connect(WEB_SOCKET)
        read_response(socket_of_web, b'\r\n\r\n')
        assert is_closed(connect())         # the time of a header has passed
        Slow.go_on.set()
        read_response(slow)
        socket_of_web.settimeout(0.1)
        with pytest.raises(socket.timeout):
            socket_of_web.recv(1)


def test_strangers_push_out_strangers_and_never_visitors_with_the_token(serve, monkeypatch):
    monkeypatch.setattr(connections, 'MAX_STRANGERS', 3)
    with open_connections(serve()) as connect:
        visitor = connect(request('with-token') + b'\r\n')
        read_response(visitor)
        strangers = [connect(request()) for _ in range(20)]
        assert all(map(is_closed, strangers[:-3]))
        visitor.sendall(request() + b'\r\n')
        read_response(visitor)
        other = connect(request('with-token') + b'\r\n')
        read_response(other)
        assert is_closed(strangers[-3])
        strangers[-1].sendall(b'\r\n')
        read_response(strangers[-1])


def test_a_server_answers_until_it_is_closed(monkeypatch):
    monkeypatch.setattr(page, 'END_TIMEOUT_S', DEADLINE_S)   # for a busy machine
    failures, sock = [], listen('127.0.0.1', free_port())
    url = 'http://127.0.0.1:{}/'.format(sock.getsockname()[1])
    running = Server(hello, sock, failures.append)
    with urllib.request.urlopen(url, timeout=DEADLINE_S) as answer:
        assert answer.read() == b'hello' and answer.headers['server'] is None
        assert answer.headers['x-frame-options'] == 'DENY'
        assert answer.headers['x-content-type-options'] == 'nosniff'
        assert answer.headers['referrer-policy'] == 'no-referrer'
    running.close()
    assert failures == []
    with pytest.raises(OSError):
        urllib.request.urlopen(url, timeout=5)


def test_an_application_that_does_not_start_is_an_error():
    async def fails(scope, receive, send):
        assert scope['type'] == 'lifespan'
        await receive()
        await send({'type': 'lifespan.startup.failed', 'message': 'no'})
    failures = []
    running = Server(fails, listen('127.0.0.1', free_port()), failures.append)
    wait_for(lambda: failures, 'the error')
    running.close()
    assert [str(error) for error in failures] == [
        'the page cannot be served: its application does not start']


class Cycle:
    """The garbage collector runs its code."""

    def __init__(self):
        self.cycle = self

    def __del__(self):
        sum(range(20))


def test_threads_that_parse_do_not_disturb_one_another(monkeypatch):
    monkeypatch.setattr(ast, 'parse', ast.parse)        # it is put back after the test
    page.parse_in_turn()
    errors, end_s = [], time.monotonic() + 1

    def parse(depth):
        return parse(depth - 1) if depth else ast.literal_eval('["a", ("b", {"c": [1, 2]})]')

    def work(depth):
        while time.monotonic() < end_s:
            Cycle()
            try:
                parse(depth)
            except SystemError as error:
                errors.append(error)
    threads = [threading.Thread(target=work, args=(depth,)) for depth in (1, 20)]
    interval_s, thresholds = sys.getswitchinterval(), gc.get_threshold()
    try:
        sys.setswitchinterval(1e-6)
        gc.set_threshold(5)
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval_s)
        gc.set_threshold(*thresholds)
    assert errors == []
