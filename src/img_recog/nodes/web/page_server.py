"""Serves the page: an HTTP server in a thread, and the socket that it listens on."""
import ast
import asyncio
import contextlib
import functools
import logging
import os
import socket
import threading
from typing import Any, Callable, Optional

import uvicorn

from img_recog.errors import UserError, one_line
from img_recog.nodes.web.connections import ACCEPTED_AT_A_TIME, HEADER_TIMEOUT_S, Connection

PORTS = 11             # tried, from the first one on
_MAX_PORT = 65535
END_TIMEOUT_S = 2.0
_MAX_BYTES = 1 << 16    # of the header of a request, and of a message on a WebSocket
_HEADERS = [('x-frame-options', 'DENY'), ('x-content-type-options', 'nosniff'),
            ('referrer-policy', 'no-referrer')]
# they log a traceback for each message of a browser that makes no sense
_LOGGERS = ('asyncio', 'engineio.server', 'nicegui', 'socketio.server')


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens at this address, at the first port from `port` on that is free.

    Raises UserError if there is none, or no such address.
    """
    last: Optional[OSError] = None
    for number in range(port, min(port + PORTS, _MAX_PORT + 1)):
        try:
            return socket.create_server(
                (host, number), family=socket.AF_INET6 if ':' in host else socket.AF_INET)
        except (OSError, OverflowError) as error:
            last = error if isinstance(error, OSError) else OSError(str(error))
    raise UserError('cannot serve the page at {}, ports {} to {}: {}'.format(
        host, port, min(port + PORTS - 1, _MAX_PORT), one_line(last)),
        'set web_port to a port from 1024 on' if isinstance(last, PermissionError) else
        'set web_host to an address of this computer, and web_port to a free port')


def parse_in_turn() -> None:
    """Let `ast.parse` run in one thread at a time, which NiceGUI calls for properties of elements.

    In CPython 3.11, two threads that parse fail with "SystemError: AST constructor recursion depth
    mismatch" if the garbage collector runs code of Python meanwhile. Then the page was an error.
    """
    parse, lock = ast.parse, threading.RLock()

    @functools.wraps(parse)
    def parse_alone(*arguments: Any, **options: Any) -> ast.AST:
        with lock:
            return parse(*arguments, **options)
    ast.parse = parse_alone     # type: ignore[assignment]


class _Reports(logging.Handler):
    """Passes the errors of libraries on."""

    def __init__(self, report: Callable[[Exception], None]):
        super().__init__(logging.ERROR)
        self._report = report

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        self._report(error if isinstance(error, Exception) else RuntimeError(
            '{}: {}'.format(record.name, record.getMessage())))


def report_errors(report: Callable[[Exception], None]) -> None:
    """Call `report` with what the libraries of the page log as errors, in place of a traceback."""
    for name in _LOGGERS:
        logger = logging.getLogger(name)
        logger.handlers, logger.propagate = [_Reports(report)], False


class Server:
    """Runs an ASGI application in a thread until it is closed."""

    def __init__(self, app: Any, sock: socket.socket, failed: Callable[[Exception], None]):
        """Start to serve; failed: is called with an error that ends the server."""
        # JPEG images do not get smaller
        self._server = uvicorn.Server(uvicorn.Config(
            app, http=Connection, backlog=ACCEPTED_AT_A_TIME, log_level='error',
            access_log=False, h11_max_incomplete_event_size=_MAX_BYTES, ws_max_size=_MAX_BYTES,
            lifespan='on', server_header=False, headers=_HEADERS, ws_per_message_deflate=False,
            timeout_keep_alive=int(HEADER_TIMEOUT_S), timeout_graceful_shutdown=1))
        self._sock, self._failed = sock, failed
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End all connections, and wait for the end of the thread."""
        self._server.should_exit = True
        self._thread.join(END_TIMEOUT_S)
        self._server.force_exit = True

    def _run(self) -> None:
        try:
            with contextlib.suppress(SystemExit):       # of some uvicorn, if `app` does not start
                asyncio.run(self._server.serve(sockets=[self._sock]))
            if not self._server.started:
                raise UserError('the page cannot be served: its application does not start')
        except Exception as error:
            self._failed(error)


def address(sock: socket.socket, token: str) -> str:
    """Return the address of the page for a browser on this computer or for others."""
    host, port = sock.getsockname()[:2]
    if host in ('127.0.0.1', '::1'):
        host = 'localhost'
    elif host in ('0.0.0.0', '::'):
        # only a container knows its name; the image says under which name browsers reach it
        host = os.environ.get('IMG_RECOG_PAGE_HOST') or socket.gethostname()
    return 'http://{}:{}/?token={}'.format('[{}]'.format(host) if ':' in host else host,
                                           port, token)
