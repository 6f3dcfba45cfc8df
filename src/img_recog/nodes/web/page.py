"""The page, built with NiceGUI: its frame around the tabs.

What moves is drawn by static/*.js in the browser, from what feed.py sends.
"""
import ast
import asyncio
import contextlib
import functools
import json
import logging
import os
import socket
import threading
import time
import urllib.parse
from functools import partial
from typing import Any, Callable, List, Optional

import uvicorn
from fastapi import FastAPI, Request
from fastapi.staticfiles import StaticFiles
from nicegui import Client, run, ui

from img_recog.errors import UserError, one_line
from img_recog.nodes.web import page_texts
from img_recog.nodes.web.connections import ACCEPTED_AT_A_TIME, HEADER_TIMEOUT_S, Connection
from img_recog.nodes.web.page_elements import Shared, Visit
from img_recog.nodes.web.tabs import TABS

PORTS = 11             # tried, from the first one on
_MAX_PORT = 65535
END_TIMEOUT_S = 2.0
_MAX_BYTES = 1 << 16    # of the header of a request, and of a message on a WebSocket
_HEADERS = [('x-frame-options', 'DENY'), ('x-content-type-options', 'nosniff'),
            ('referrer-policy', 'no-referrer')]
# they log a traceback for each message of a browser that makes no sense
_LOGGERS = ('asyncio', 'engineio.server', 'nicegui', 'socketio.server')
_STATIC = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'static')
_POLL_S = 0.4           # of values that other pages or nodes may change
_MAX_WAITING = 20       # pages whose browser has not opened a WebSocket yet
_PATIENCE_S = 5.0       # with a robot that is gone: a new master knows its nodes one by one


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


def build(app: FastAPI, shared: Shared) -> None:
    """Add the page to an application, and let NiceGUI serve it."""
    app.mount('/static', StaticFiles(directory=_STATIC))
    for tab in TABS:
        if tab.serve is not None:
            tab.serve(app)
    waiting: List[Client] = []

    @ui.page('/')
    async def index(request: Request) -> None:
        language = page_texts.language_of(request.headers.get('accept-language', ''))
        robot = await run.io_bound(shared.robots.get, request.query_params.get('robot', ''))
        pictures = await run.io_bound(robot.picture_topics)
        _Page(Visit(shared, robot, page_texts.Texts(language), pictures))
        _keep_few(waiting, ui.context.client)

    ui.run_with(app, title='img_recog', dark=None, tailwind=False, reconnect_timeout=5.0)


def _keep_few(waiting: List[Client], client: Client) -> None:
    """Delete the oldest page if too many wait; NiceGUI keeps each for a minute, with 0.5 MB."""
    def connected() -> None:
        if client in waiting:
            waiting.remove(client)
    client.on_connect(connected)
    waiting[:] = [each for each in waiting if each.id in Client.instances] + [client]
    if len(waiting) > _MAX_WAITING:
        waiting.pop(0).delete()


class _Page:
    """One page of one visitor, for one robot."""

    def __init__(self, visit: Visit):
        """Add all elements."""
        self._visit, self._robot, self._t = visit, visit.robot, visit.texts
        self._names: List[str] = []
        self._seen_s = time.monotonic()
        self._updates: List[Callable[[], None]] = []
        ui.add_head_html(
            '<script>window.texts = {}; window.robot = {}; document.documentElement.lang = "{}";'
            '</script>{}<link rel="stylesheet" href="/static/page.css">'.format(
                json.dumps(self._t.all), json.dumps(self._robot.name), self._t.language,
                ''.join('<script src="/static/{}.js" defer></script>'.format(name)
                        for name in ('page', 'mapping', *(tab.name for tab in TABS)))))
        ui.page_title(self._t('title'))
        header = self._header()
        with ui.tab_panels(header, value=TABS[0].name, animated=False,
                           keep_alive=True).classes('panels'):
            for tab in TABS:
                with ui.tab_panel(tab.name):
                    added = tab.add(visit)
                if tab.update is not None:
                    self._updates.append(partial(tab.update, added))
        ui.timer(_POLL_S, self._poll)
        # A connection that was lost is often noticed after the next one has been made.
        client = ui.context.client
        client.on_connect(lambda: self._watch(True))
        client.on_disconnect(lambda: self._watch(client.has_socket_connection))

    def _watch(self, is_watched: bool) -> None:
        for tuning in (self._robot.colors, self._visit.shared.simulator):
            tuning.watch_for(self, is_watched)

    def _poll(self) -> None:
        """Show what other pages and nodes have changed."""
        names, now_s = self._visit.shared.robots.names, time.monotonic()
        if self._robot.name not in names:
            if now_s - self._seen_s > _PATIENCE_S:
                ui.navigate.to('/')
            return
        self._seen_s = now_s
        if names != self._names:
            self._names = names
            self._select.set_options(names, value=self._robot.name)
            self._select.set_visibility(len(names) > 1)
        for update in self._updates:
            update()
        self._show_tabs()

    def _show_tabs(self) -> None:
        """Show the titles of the tabs that are there."""
        for tab in TABS:
            if tab.is_there is not None:
                self._tabs[tab.name].set_visibility(tab.is_there(self._visit))

    def _header(self) -> ui.tabs:
        with ui.header().style('padding: 0 8px; gap: 8px; align-items: center'):
            ui.label('img_recog').classes('brand').style('font-weight: 600')
            self._select = ui.select(
                [self._robot.name], value=self._robot.name, on_change=self._choose).props(
                    'dense options-dense dark borderless aria-label="{}"'.format(
                        self._t('robot'))).classes('robot')
            self._select.set_visibility(False)
            with ui.tabs().props('dense no-caps inline-label outside-arrows mobile-arrows') \
                    .style('flex: 1; min-width: 0') as tabs:
                self._tabs = {tab.name: ui.tab(tab.name, label=self._t(tab.name)) for tab in TABS}
            self._show_tabs()
            ui.label(self._t('disconnected')).classes('status').props(
                'data-bind=connection role=status')
        return tabs

    def _choose(self) -> None:
        if self._select.value != self._robot.name:
            ui.navigate.to('/?robot=' + urllib.parse.quote(self._select.value))
