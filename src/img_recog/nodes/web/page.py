"""The page, built with NiceGUI: its frame around the tabs.

What moves is drawn by static/*.js in the browser, from what feed.py sends.
"""
import json
import os
import time
import urllib.parse
from functools import partial
from typing import Callable, List

from fastapi import FastAPI, Request
from fastapi.staticfiles import StaticFiles
from nicegui import Client, run, ui

from img_recog.nodes.web import page_texts
from img_recog.nodes.web.page_elements import Shared, Visit
from img_recog.nodes.web.page_texts import Texts
from img_recog.nodes.web.tabs import TABS

_STATIC = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'static')
_POLL_S = 0.4           # of values that other pages or nodes may change
_MAX_WAITING = 20       # pages whose browser has not opened a WebSocket yet
_PATIENCE_S = 5.0       # with a robot that is gone: a new master knows its nodes one by one


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
        _Page(Visit(shared, robot, Texts(language), pictures))
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
