"""The page, built with NiceGUI: what stands where, and what its elements call.

What moves is drawn by static/live.js in the browser, from what feed.py sends.
"""
import json
import os
import time
from functools import partial
from typing import Any, Dict, List, Protocol, Sequence, Tuple

from fastapi import FastAPI, Request, Response
from fastapi.staticfiles import StaticFiles
from nicegui import run, ui

from img_recog.errors import UserError, one_line
from img_recog.nodes.web.texts import language_of, texts

_STATIC = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'static')
_POLL_S = 0.4           # of values that other pages or nodes may change
_FACTORS = {0.25: '0.25', 0.5: '0.5', 1.0: '1', 2.0: '2', 5.0: '5', 0.0: ''}
_BOUNDS = ('saturation', 'value')
# readable on a light and on a dark card
_CHART_TEXT, _CHART_LINES = '#8b919c', '#8b919c44'
_LEVELS = ('debug', 'info', 'warn', 'error')
_SLIDER_THROTTLE_S = 0.05
_SETTLE_S = 1.0
_PAD: Sequence[Tuple[str, str, str]] = (      # text, icon, direction; by rows of three
    ('', '', ''), ('forward', 'arrow_upward', '1,0'), ('', '', ''),
    ('left', 'rotate_left', '0,1'), ('stop', 'stop', '0,0'), ('right', 'rotate_right', '0,-1'),
    ('', '', ''), ('backward', 'arrow_downward', '-1,0'), ('', '', ''))


class System(Protocol):
    """What the page shows and does, see node.py; methods that wait are called in threads."""

    colors: Any
    simulator: Any
    driving: Any

    def picture_topics(self) -> List[Tuple[str, str, str]]:
        """Return topic, key of its title and color of each picture."""

    def act(self, action: str) -> None:
        """Call a service of the simulator."""

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Move the robot."""

    def propose(self, topic: str, x: float, y: float, color: str) -> Dict[str, int]:
        """Set bounds of a color around that in a picture; return them."""

    def save_colors(self) -> str:
        """Save the parameters of the colors; return the path."""

    def record(self, is_wanted: bool) -> str:
        """Start or stop a recording; return its path."""

    def recording(self) -> str:
        """Return the path of the recording that runs, '' if there is none."""

    def graph(self, is_dark: bool, leaves: bool) -> bytes:
        """Return the graph of nodes and topics as SVG."""

    def watch(self, page: object, is_watched: bool) -> None:
        """Begin or end to follow the parameters for a page."""


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
    def index(request: Request) -> None:
        language = language_of(request.headers.get('accept-language', ''))
        _Page(system, language).build()

    ui.run_with(app, title='img_recog', dark=None, tailwind=False, reconnect_timeout=5.0)


class _Page:
    """One page of one visitor."""

    def __init__(self, system: System, language: str):
        self._system, self._language, self._texts = system, language, texts(language)
        self._sliders: Dict[str, Any] = {}
        self._moved_s: Dict[str, float] = {}        # when the visitor moved them
        self._revision = -1
        self._picked = ''

    def build(self) -> None:
        """Add all elements."""
        ui.add_head_html('<script>window.texts = {}; document.documentElement.lang = "{}";'
                         '</script><script src="/static/live.js" defer></script>'
                         '<link rel="stylesheet" href="/static/page.css">'.format(
                             json.dumps(self._texts), self._language))
        ui.page_title(self._t('title'))
        self._header()
        with ui.tab_panels(self._tabs, value='live', animated=False, keep_alive=True).classes(
                'panels'):
            for name in ('live', 'colors', 'graph', 'nodes', 'log'):
                with ui.tab_panel(name):
                    getattr(self, '_' + name)()
        ui.on('pose', self._on_pose, throttle=0.2)
        ui.on('pick', self._on_pick, throttle=0.2)
        ui.timer(_POLL_S, self._poll)
        # also when a connection was lost for a moment
        ui.context.client.on_connect(lambda: self._system.watch(self, True))
        ui.context.client.on_disconnect(lambda: self._system.watch(self, False))

    def _t(self, key: str, *values: Any) -> str:
        return self._texts[key].format(*values)

    def _header(self) -> None:
        with ui.header().style('padding: 0 8px; gap: 8px; align-items: center'):
            ui.label('img_recog').classes('brand').style('font-weight: 600')
            with ui.tabs().props('dense no-caps inline-label outside-arrows mobile-arrows') \
                    .style('flex: 1; min-width: 0') as self._tabs:
                for name in ('live', 'colors', 'graph', 'nodes', 'log'):
                    ui.tab(name, label=self._t(name))
            ui.label(self._t('disconnected')).classes('status').props(
                'data-bind=connection role=status')

    # the tab with pictures, map and drive buttons

    def _live(self) -> None:
        with ui.element('div').classes('board'):
            with ui.element('div').classes('column-cards'):
                with ui.element('div').classes('pictures'):
                    for topic, title, color in self._system.picture_topics():
                        self._picture(topic, self._t(title, color))
                self._chart('areas', self._t('areas'))
            with ui.element('div').classes('column-cards'):
                self._map()
                self._chart('speeds', self._t('speeds'))
            with ui.element('div').classes('column-cards'):
                self._drive()
                self._simulation()

    def _picture(self, topic: str, title: str, classes: str = '') -> None:
        with ui.element('section').classes('card'):
            _heading(title)
            with ui.element('div').classes('picture'):
                ui.element('canvas').classes(classes).props(
                    'data-picture="{}" role=img aria-label="{}"'.format(topic, title))
                with ui.element('div').classes('empty'):
                    ui.label(self._t('no_image'))

    def _chart(self, name: str, title: str) -> None:
        with ui.element('section').classes('card'):
            _heading(title)
            axis = {'type': 'value', 'axisLabel': {'hideOverlap': True, 'color': _CHART_TEXT},
                    'splitNumber': 4, 'splitLine': {'lineStyle': {'color': _CHART_LINES}},
                    'nameTextStyle': {'color': _CHART_TEXT}}
            ui.echart({
                'grid': {'left': 48, 'right': 12, 'top': 26, 'bottom': 34},
                'legend': {'top': 0, 'textStyle': {'color': _CHART_TEXT}},
                'xAxis': dict(axis, min=-20, max=0, name=self._t('seconds'),
                              nameLocation='middle', nameGap=18),
                'yAxis': axis, 'series': []}).classes('chart').props(
                    'data-chart={} role=img aria-label="{}"'.format(name, title))

    def _map(self) -> None:
        with ui.element('section').classes('card'):
            _heading(self._t('map'))
            ui.element('canvas').classes('map').props(
                'role=img aria-label="{}"'.format(self._t('map_label')))
            ui.element('p').props('data-bind=pose aria-live=off')
            _paragraph(self._t('map_help'))

    def _drive(self) -> None:
        settings = self._system.driving.settings
        with ui.element('section').classes('card'):
            _heading(self._t('drive'))
            with ui.element('div').classes('pad').props(
                    'role=group aria-label="{}"'.format(self._t('drive'))):
                for key, icon, direction in _PAD:
                    if not key:
                        ui.element('div')
                        continue
                    ui.button(icon=icon).props(
                        'data-drive="{}" aria-label="{}" title="{}"'.format(
                            direction, self._t(key), self._t(key)))
            ui.element('p').props('data-bind=busy role=status')
            _paragraph(self._t('drive_help'))
            for name in ('max_linear', 'max_angular'):
                field = name + '_velocity'
                highest = getattr(settings, field)
                self._slider(self._t(name), highest / 20, highest, highest / 20,
                             getattr(settings, field),
                             partial(self._system.driving.limit, field))

    def _simulation(self) -> None:
        with ui.element('section').classes('card'):
            _heading(self._t('simulation'))
            with ui.row().style('gap: 6px'):
                for action, key, icon in (('pause_physics', 'pause', 'pause'),
                                          ('unpause_physics', 'resume', 'play_arrow'),
                                          ('reset_world', 'reset_world', 'replay')):
                    ui.button(icon=icon, on_click=partial(self._act, action)).props(
                        'dense aria-label="{0}" title="{0}"'.format(self._t(key)))
                self._record_button = ui.button(
                    icon='fiber_manual_record', on_click=self._record).props(
                        'dense aria-label="{0}" title="{0}"'.format(self._t('record')))
            with ui.element('p'):
                ui.label(self._t('factor') + ': ').style('display: inline')
                ui.label('').props('data-bind=factor').style('display: inline')
            self._factor = ui.select(
                {value: text or self._t('fastest') for value, text in _FACTORS.items()},
                value=1.0, label=self._t('factor'), on_change=self._on_factor).props(
                    'dense options-dense').style('width: 100%')
            self._view = ui.select(
                {'above': self._t('above'), 'follow': self._t('follow')}, value='above',
                label=self._t('viewpoint'), on_change=self._on_view).props(
                    'dense options-dense').style('width: 100%')

    # the tab with the bounds of the colors

    def _colors(self) -> None:
        with ui.element('div').classes('tuning'):
            with ui.element('div').classes('column-cards'):
                pictures = self._system.picture_topics()
                for topic, title, color in pictures[:3]:
                    self._picture(topic, self._t(title, color),
                                  'pick' if title == 'camera' else '')
            self._tuning = ui.element('div').classes('column-cards')

    def _tune(self, values: Dict[str, Any], names: Sequence[str]) -> None:
        """Make the sliders of all colors."""
        self._tuning.clear()
        self._sliders.clear()
        with self._tuning:
            if not names:
                _paragraph(self._t('no_recognition'))
                return
            self._picked = self._picked if self._picked in names else names[0]
            ui.toggle({name: name for name in names}, value=self._picked,
                      on_change=lambda event: setattr(self, '_picked', event.value)).props(
                          'dense no-caps')
            _paragraph(self._t('pick', ', '.join(names)))
            for name in names:
                with ui.element('section').classes('card'):
                    _heading(name)
                    with ui.element('div').classes('sliders'):
                        self._color(name, values)
            ui.button(self._t('save'), icon='save', on_click=self._save).props('no-caps')

    def _color(self, name: str, values: Dict[str, Any]) -> None:
        for part in ('hue_min', 'hue_max'):
            self._tuned(self._t(part), name + '_' + part, 0, 180, 1, values, 'hue')
        for part in _BOUNDS:
            for end in ('min', 'max'):
                self._tuned('{}, {}'.format(self._t(part), end),
                            '{}_{}_{}'.format(name, part, end), 0, 255, 1, values)
        self._tuned(self._t('area_limit'), name + '_area_limit', 0, 20000, 50, values)
        self._tuned(self._t('linear_x'), name + '_linear_x', -10, 10, 0.01, values)
        self._tuned(self._t('angular_z'), name + '_angular_z', -3, 3, 0.05, values)

    def _tuned(self, title: str, parameter: str, low: float, high: float, step: float,
               values: Dict[str, Any], classes: str = '') -> None:
        is_whole = isinstance(values[parameter], int)

        def change(value: float) -> None:
            self._moved_s[parameter] = time.monotonic()
            self._system.colors.change(**{parameter: int(value) if is_whole else float(value)})
        self._sliders[parameter] = self._slider(title, low, high, step, values[parameter],
                                                change, classes)

    def _slider(self, title: str, low: float, high: float, step: float, value: float,
                change: Any, classes: str = '') -> Any:
        with ui.element('div').classes('slider-row'):
            ui.label(title)
            shown = ui.label()
            slider = ui.slider(min=low, max=high, step=step, value=value).classes(classes).props(
                'aria-label="{}"'.format(title))
            shown.bind_text_from(slider, 'value', lambda value: '{:g}'.format(value))
            slider.on('update:model-value', lambda event: change(event.args),
                      throttle=_SLIDER_THROTTLE_S)
        return slider

    # the other tabs

    def _graph(self) -> None:
        with ui.element('section').classes('card'):
            ui.checkbox(self._t('leaves'), value=True, on_change=lambda event: ui.run_javascript(
                'document.querySelector("[data-graph]").dataset.graph = {}; loadGraph()'.format(
                    int(event.value)))).props('dense')
            with ui.element('div').classes('graph'):
                ui.element('img').props('data-graph=1 alt="{}"'.format(self._t('graph_label')))

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

    # what a visitor does

    async def _wait(self, function: Any, *arguments: Any) -> Any:
        """Call a function in a thread; show its UserError, and return None then."""
        try:
            return await run.io_bound(function, *arguments)
        except UserError as error:
            ui.notify(one_line(error), type='negative')
            return None

    async def _act(self, action: str) -> None:
        await self._wait(self._system.act, action)

    async def _on_pose(self, event: Any) -> None:
        try:
            x, y, yaw = (float(event.args[key]) for key in ('x', 'y', 'yaw'))
        except (TypeError, ValueError, KeyError):
            return
        await self._wait(self._system.set_pose, x, y, yaw)

    async def _on_pick(self, event: Any) -> None:
        try:
            topic, (x, y) = str(event.args['topic']), (float(event.args[key]) for key in 'xy')
        except (TypeError, ValueError, KeyError):
            return
        color = self._picked
        bounds = await self._wait(self._system.propose, topic, x, y, color)
        if bounds:
            ui.notify(self._t('proposed', color, bounds['hue_min'], bounds['hue_max']))

    async def _save(self) -> None:
        path = await self._wait(self._system.save_colors)
        if path:
            ui.notify(self._t('saved', path), multi_line=True, timeout=10000)

    async def _record(self) -> None:
        is_running = bool(self._system.recording())
        path = await self._wait(self._system.record, not is_running)
        if path:
            ui.notify(self._t('recorded' if is_running else 'recording_to', path),
                      multi_line=True)

    def _on_factor(self, event: Any) -> None:
        if event.value != self._system.simulator.values().get('real_time_factor'):
            self._system.simulator.change(real_time_factor=float(event.value))

    def _on_view(self, event: Any) -> None:
        if event.value != self._system.simulator.values().get('view'):
            self._system.simulator.change(view=event.value)

    def _poll(self) -> None:
        """Show what other pages and nodes have changed."""
        is_recording = bool(self._system.recording())
        self._record_button.props('color={0} aria-label="{1}" title="{1}"'.format(
            'negative' if is_recording else 'primary',
            self._t('stop_recording' if is_recording else 'record')))
        simulator = self._system.simulator.values()
        if simulator.get('view') in self._view.options:
            self._view.value = simulator['view']
        if simulator.get('real_time_factor') in _FACTORS:
            self._factor.value = simulator['real_time_factor']
        revision = self._system.colors.revision
        if revision == self._revision:
            return
        self._revision, values = revision, self._system.colors.values()
        names = color_names_in(values)
        if [name + '_hue_min' for name in names] != [
                each for each in self._sliders if each.endswith('_hue_min')]:
            self._tune(values, names)
        ui.run_javascript('window.limits = {}'.format(json.dumps(
            {name: values[name + '_area_limit'] for name in names})))
        now_s = time.monotonic()
        for parameter, slider in self._sliders.items():
            if parameter in values and slider.value != values[parameter]:
                # one that is being moved is ahead of its parameter
                if now_s - self._moved_s.get(parameter, 0.0) < _SETTLE_S:
                    self._revision = -1
                else:
                    slider.value = values[parameter]


def color_names_in(values: Dict[str, Any]) -> List[str]:
    """Return the names of the colors for which there are parameters, in their order."""
    ending = '_hue_min'
    return [name[:-len(ending)] for name in values if name.endswith(ending)]


def _heading(text: str) -> None:
    with ui.element('h2'):
        ui.label(text)


def _paragraph(text: str) -> None:
    with ui.element('p'):
        ui.label(text)
