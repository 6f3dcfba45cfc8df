"""Connections of clients that send what no client should."""
import contextlib
import socket

from img_recog_helpers.waiting import DEADLINE_S


@contextlib.contextmanager
def connections(address):
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
