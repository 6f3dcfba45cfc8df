"""Connections to the port of rospy's real server that send a header late, never or a wrong one."""
import socket
import struct
import subprocess
import sys
import threading
import time
import xmlrpc.client

import pytest
from rosgraph import network
from rospy.impl.tcpros_base import TCPROSServer, TCPServer

from img_recog.ros.transport import handshakes, switch, xmlrpc_requests
from img_recog.ros.transport.handshakes import Handshakes
from img_recog_testing.connecting import connections, is_closed
from img_recog_testing.waiting import DEADLINE_S, wait_for

HEADER = network.encode_ros_handshake_header({'topic': '/t', 'callerid': '/c', 'md5sum': '*'})


@pytest.fixture
def server(fast, monkeypatch):
    """rospy's server; `accepted` has the headers of its subscribers, `lines` the warnings."""
    monkeypatch.setenv('ROS_HOSTNAME', '127.0.0.1')
    monkeypatch.setattr(TCPROSServer, '_tcp_server_callback', TCPROSServer._tcp_server_callback)
    monkeypatch.setattr(TCPServer, '_create_server_sock', TCPServer._create_server_sock)
    monkeypatch.setattr(xmlrpc_requests, 'install', lambda: None)
    monkeypatch.setattr(handshakes, 'ThrottledWarning',
                        lambda: lambda text, *values: lines.append(text % values))
    lines = []
    handshakes.install()
    server = TCPROSServer()
    server.accepted, server.lines, server.problem = [], lines, None

    def handle(sock, address, header):
        assert sock.gettimeout() is None
        server.accepted.append(header)
        sock.sendall(b'welcome')
        return server.problem
    server.topic_connection_handler = server.service_connection_handler = handle
    server.start_server()
    yield server
    server.shutdown()


@pytest.fixture
def connect(server):
    """A function that connects to the server and sends data."""
    with connections(server.get_address()) as connect:
        yield connect


def test_a_subscriber_is_accepted_while_others_send_nothing(server, connect):
    idle = [connect(), connect(HEADER[:3]), connect(HEADER[:-1])]
    begin_s = time.monotonic()
    assert connect(HEADER).recv(7) == b'welcome'
    assert time.monotonic() - begin_s < DEADLINE_S / 2
    assert server.accepted == [{'topic': '/t', 'callerid': '/c', 'md5sum': '*'}]
    assert all(map(is_closed, idle))
    wait_for(lambda: len(server.lines) == len(idle), 'a line for each')
    assert set(server.lines) == {'connection from 127.0.0.1 refused: it has sent no complete '
                                 'header of TCPROS within 5 s'}


def test_a_header_that_arrived_while_the_node_was_busy_is_accepted(server, monkeypatch):
    monkeypatch.setattr(handshakes, '_TIME_LIMIT_S', 0)
    peer, sock = socket.socketpair()
    peer.settimeout(DEADLINE_S)
    with peer, sock:
        peer.sendall(HEADER)
        Handshakes().accept(server, sock, ('127.0.0.1', 1))
        assert peer.recv(7) == b'welcome'
    assert server.lines == []


def test_a_header_in_parts_is_accepted(server, connect, monkeypatch):
    monkeypatch.setattr(handshakes, '_TIME_LIMIT_S', DEADLINE_S)
    sock = connect(HEADER[:2])
    sock.sendall(HEADER[2:9])
    sock.sendall(HEADER[9:])
    assert sock.recv(7) == b'welcome' and server.lines == []


def test_the_limit_is_for_the_whole_header(server, connect, monkeypatch):
    monkeypatch.setattr(handshakes, '_TIME_LIMIT_S', 0.25)
    sock, stop = connect(), threading.Event()

    def drip():
        try:
            for byte in (HEADER + bytes(10000))[:2000]:
                sock.sendall(bytes([byte]))
                if stop.wait(0.1):
                    return
        except OSError:
            pass
    thread = threading.Thread(target=drip, daemon=True)
    thread.start()
    assert is_closed(sock)
    stop.set()
    thread.join()
    assert server.accepted == []


@pytest.mark.parametrize('data', [
    struct.pack('<I', 0xffffffff) + b'xxx', b'GET / HTTP/1.1\r\n\r\n',
    struct.pack('<II', 10, 0) + bytes(6), struct.pack('<II', 8, 4) + b'\xff=\xff\xff',
    struct.pack('<II', 8, 4) + b'none', struct.pack('<II', 8, 4000) + b'none',
    struct.pack('<II', 7, 3) + b'a=b', struct.pack('<I', 0)], ids=repr)
def test_garbage_costs_one_line(server, connect, data):
    sock = connect(data)
    try:
        assert b'welcome' not in sock.recv(1000)
    except ConnectionResetError:
        pass
    line = wait_for(lambda: server.lines, 'a line')[0]
    assert line.startswith('connection from 127.0.0.1 refused: it') and len(server.lines) == 1


def test_a_connection_that_is_only_closed_costs_no_line(server, connect):
    sock = connect()
    sock.shutdown(socket.SHUT_WR)
    assert is_closed(sock) and server.lines == []


def test_the_subscriber_gets_the_reason_of_a_refusal(server, connect):
    server.problem = 'wrong\ntype'
    sock = connect(HEADER)
    answer = b''
    while b'wrong' not in answer:
        answer += sock.recv(1000)
    assert answer == b'welcome' + network.encode_ros_handshake_header({'error': 'wrong\ntype'})
    assert is_closed(sock)
    assert wait_for(lambda: server.lines, 'a line') == [
        r'connection from 127.0.0.1 refused: wrong\ntype']


def test_if_too_many_connections_wait_the_oldest_is_closed(server, connect, monkeypatch):
    monkeypatch.setattr(handshakes, '_MAX_WAITING', 3)
    monkeypatch.setattr(handshakes, '_TIME_LIMIT_S', 10 * DEADLINE_S)
    socks = []
    for _ in range(6):       # more would wait for the kernel: rospy listens with a backlog of 5
        socks.append(connect())
    assert all(is_closed(sock) for sock in socks[:-3])
    for sock in socks[-3:]:
        sock.sendall(HEADER)
        assert sock.recv(7) == b'welcome'
    assert connect(HEADER).recv(7) == b'welcome'


def test_the_server_of_plain_rospy_is_not_changed(monkeypatch):
    before = TCPROSServer._tcp_server_callback
    monkeypatch.setenv(switch.VARIABLE, 'handshakes')
    handshakes.install()
    assert TCPROSServer._tcp_server_callback is before


def test_without_threads_the_connection_is_closed(monkeypatch):
    class NoThread:
        def __init__(self, **_):
            pass

        def start(self):
            raise RuntimeError("can't start new thread")
    monkeypatch.setattr(handshakes.threading, 'Thread', NoThread)
    ours, theirs = socket.socketpair()
    with ours:
        Handshakes().accept(None, theirs, ('127.0.0.1', 1))
        assert is_closed(ours)


CHILD = """
import resource, sys, threading
from rosgraph.xmlrpc import ThreadingXMLRPCServer
from rospy.impl.tcpros_base import TCPROSServer
from img_recog.ros.transport import handshakes
handshakes.install()
server = TCPROSServer()
server.topic_connection_handler = lambda sock, address, header: sock.sendall(b'welcome')
server.start_server()
xmlrpc = ThreadingXMLRPCServer(('127.0.0.1', 0), 0)
xmlrpc.register_function(lambda: 'pong', 'ping')
threading.Thread(target=xmlrpc.serve_forever, daemon=True).start()
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
print(server.get_address()[1], xmlrpc.server_address[1], flush=True)
sys.stdin.read()
"""


def test_after_too_many_connections_a_node_accepts_again(monkeypatch):
    monkeypatch.setenv('ROS_HOSTNAME', '127.0.0.1')
    with subprocess.Popen([sys.executable, '-c', CHILD], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        ports = [int(word) for word in child.stdout.readline().split()]
        for port in ports:
            socks = []
            for _ in range(100):
                try:
                    socks.append(socket.create_connection(('127.0.0.1', port), 1))
                except socket.timeout:      # nobody accepts
                    break
                time.sleep(0.01)    # else the backlog is full before there are 64
            assert len(socks) > 50
            for sock in socks:
                sock.close()
        with socket.create_connection(('127.0.0.1', ports[0]), DEADLINE_S) as sock:
            sock.sendall(HEADER)
            assert sock.recv(7) == b'welcome'
        with xmlrpc.client.ServerProxy('http://127.0.0.1:{}'.format(ports[1])) as node:
            assert node.ping() == 'pong'
        child.stdin.close()
