"""The page, built with NiceGUI: its frame, and the tabs without state.

What moves is drawn by static/live.js in the browser, from what feed.py sends.
"""
import json
import os
import time
import urllib.parse
from typing import List

from fastapi import FastAPI, Request, Response
from fastapi.staticfiles import StaticFiles
from nicegui import run, ui

from img_recog.errors import UserError, one_line
from img_recog.nodes.web.colors_tab import ColorsTab
from img_recog.nodes.web.live_tab import LiveTab
from img_recog.nodes.web.system import PictureTopic, Robot, System
from img_recog.nodes.web.texts import Texts, language_of

_STATIC = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'static')
_POLL_S = 0.4           # of values that other pages or nodes may change
_PATIENCE_S = 5.0       # with a robot that is gone: a new master knows its nodes one by one
_TABS = ('live', 'colors', 'graph', 'nodes', 'log')
_LEVELS = ('debug', 'info', 'warn', 'error')


def build(app: FastAPI, system: System) -> None:
    """Add the page to an application, and let NiceGUI serve it."""
    app.mount('/static', StaticFiles(directory=_STATIC))

    @app.get('/graph.svg')
    def graph(dark: bool = False, leaves: bool = False) -> Response:
        try:
            return Response(system.graph(dark, leaves), media_type='image/svg+xml',
                            headers={'Cache-Control': 'no-store'})
        except UserError as error:
            return Response(one_line(error), status_code=503)

    @ui.page('/')
    async def index(request: Request) -> None:
        texts = Texts(language_of(request.headers.get('accept-language', '')))
        robot = await run.io_bound(system.robot, request.query_params.get('robot', ''))
        pictures = await run.io_bound(robot.picture_topics)
        _Page(system, robot, texts).build(pictures)

    ui.run_with(app, title='img_recog', dark=None, tailwind=False, reconnect_timeout=5.0)


class _Page:
    """One page of one visitor, for one robot."""

    def __init__(self, system: System, robot: Robot, texts: Texts):
        self._system, self._robot, self._t = system, robot, texts
        self._names: List[str] = []
        self._seen_s = time.monotonic()

    def build(self, pictures: List[PictureTopic]) -> None:
        """Add all elements."""
        ui.add_head_html(
            '<script>window.texts = {}; window.robot = {}; document.documentElement.lang = "{}";'
            '</script><script src="/static/live.js" defer></script>'
            '<link rel="stylesheet" href="/static/page.css">'.format(
                json.dumps(self._t.all), json.dumps(self._robot.name), self._t.language))
        ui.page_title(self._t('title'))
        tabs = self._header()
        with ui.tab_panels(tabs, value='live', animated=False, keep_alive=True).classes('panels'):
            with ui.tab_panel('live'):
                self._live = LiveTab(self._system, self._robot, self._t, pictures)
            with ui.tab_panel('colors'):
                self._colors = ColorsTab(self._robot, self._t, pictures)
            for name in ('graph', 'nodes', 'log'):
                with ui.tab_panel(name):
                    getattr(self, '_' + name)()
        ui.timer(_POLL_S, self._poll)
        # A connection that was lost is often noticed after the next one has been made.
        client = ui.context.client
        client.on_connect(lambda: self._watch(True))
        client.on_disconnect(lambda: self._watch(client.has_socket_connection))

    def _watch(self, is_watched: bool) -> None:
        self._robot.watch(self, is_watched)
        self._system.watch(self, is_watched)

    def _poll(self) -> None:
        """Show what other pages and nodes have changed."""
        names, now_s = self._system.robots(), time.monotonic()
        if self._robot.name not in names:
            if now_s - self._seen_s > _PATIENCE_S:
                ui.navigate.to('/')
            return
        self._seen_s = now_s
        if names != self._names:
            self._names = names
            self._select.set_options(names, value=self._robot.name)
            self._select.set_visibility(len(names) > 1)
        self._live.update()
        self._colors.update()

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
                for name in _TABS:
                    ui.tab(name, label=self._t(name))
            ui.label(self._t('disconnected')).classes('status').props(
                'data-bind=connection role=status')
        return tabs

    def _choose(self) -> None:
        if self._select.value != self._robot.name:
            ui.navigate.to('/?robot=' + urllib.parse.quote(self._select.value))

    def _graph(self) -> None:
        with ui.element('section').classes('card'):
            ui.checkbox(self._t('leaves'), value=True, on_change=lambda event: ui.run_javascript(
                'document.querySelector("[data-graph]").dataset.graph = {}; loadGraph()'.format(
                    int(event.value)))).props('dense')
            with ui.element('div').classes('graph'):
                ui.element('img').props('data-graph=1 alt="{}"'.format(self._t('graph_label')))
                ui.element('p').props('data-bind=graph role=status')

    def _nodes(self) -> None:
        with ui.element('section').classes('card table-box'):
            with ui.element('table').classes('plain'):
                with ui.element('thead'), ui.element('tr'):
                    for key in ('node', 'state', 'rates'):
                        with ui.element('th').props('scope=col'):
                            ui.label(self._t(key))
                ui.element('tbody').props('data-nodes')

    def _log(self) -> None:
        with ui.element('section').classes('card'):
            ui.select(list(_LEVELS), value='info', label=self._t('level'),
                      on_change=lambda event: ui.run_javascript(
                          'filterLog({})'.format(json.dumps(event.value)))).props(
                              'dense options-dense').style('width: 160px')
            ui.element('div').classes('log').props(
                'data-log=info role=log tabindex=0 aria-label="{}"'.format(self._t('log')))
