"""The tab with pictures, charts, map, drive buttons and the simulation."""
import math
from functools import partial
from typing import Any, Dict, Iterable, List, Sequence, Tuple

from nicegui import ui

from img_recog.nodes.web.elements import (
    OneCall, Slider, button, card, paragraph, picture, wait_for)
from img_recog.nodes.web.system import PictureTopic, Robot, System
from img_recog.nodes.web.texts import Texts

_FACTORS = (0.25, 0.5, 1.0, 2.0, 5.0, 0.0)
# readable on a light and on a dark card
_CHART_TEXT, _CHART_LINES = '#8b919c', '#8b919c44'
# visible on white and on dark grey
_CHART_COLORS = ['#4e79d7', '#f28e2b', '#59a14f', '#b07aa1', '#3ba9b5', '#d4a72c', '#e8738a',
                 '#a17a5f']
_PAD: Sequence[Tuple[str, str, str]] = (      # text, icon, direction; by rows of three
    ('', '', ''), ('forward', 'arrow_upward', '1,0'), ('', '', ''),
    ('left', 'rotate_left', '0,1'), ('stop', 'stop', '0,0'), ('right', 'rotate_right', '0,-1'),
    ('', '', ''), ('backward', 'arrow_downward', '-1,0'), ('', '', ''))


class LiveTab:
    """The tab of one visitor."""

    def __init__(self, system: System, robot: Robot, texts: Texts,
                 pictures: List[PictureTopic]):
        """Add its elements."""
        self._system, self._robot, self._t = system, robot, texts
        self._recording_call, self._is_recording = OneCall(), False     # what the button says
        with ui.element('div').classes('board'):
            with ui.element('div').classes('column-cards'):
                with ui.element('div').classes('pictures'):
                    for topic, title, color in pictures:
                        picture(topic, texts(title, color), texts('no_image'))
                self._chart('areas', texts('areas'))
            with ui.element('div').classes('column-cards'):
                self._map()
                self._chart('speeds', texts('speeds'))
            with ui.element('div').classes('column-cards'):
                self._drive()
                self._simulation()
        ui.on('pose', self._on_pose, throttle=0.2)

    def update(self) -> None:
        """Show what other pages and nodes have changed."""
        self._is_recording = is_recording = bool(self._system.recording())
        self._record_button.props('color=' + ('negative' if is_recording else 'primary'))
        self._record_button.text = self._t('stop_recording' if is_recording else 'record')
        simulator = self._system.simulator.values()
        if simulator.get('view') in self._view.options:
            self._view.value = simulator['view']
        factor = simulator.get('real_time_factor')
        if factor is not None and factor != self._factor.value:
            self._factor.set_options(self._factors({*_FACTORS, factor}), value=factor)
        limits = self._robot.driving.limits
        for field, slider in self._limits.items():
            slider.follow(limits[field])

    def _chart(self, name: str, title: str) -> None:
        with card(title):
            axis = {'type': 'value', 'axisLabel': {'hideOverlap': True, 'color': _CHART_TEXT},
                    'splitNumber': 4, 'splitLine': {'lineStyle': {'color': _CHART_LINES}},
                    'nameTextStyle': {'color': _CHART_TEXT}}
            ui.echart({
                'animation': False,         # else the labels of an axis come later than its lines
                'grid': {'left': 48, 'right': 12, 'top': 26, 'bottom': 34},
                'color': _CHART_COLORS,
                'legend': {'top': 0, 'textStyle': {'color': _CHART_TEXT}},
                'xAxis': dict(axis, min=-20, max=0, name=self._t('seconds'),
                              nameLocation='middle', nameGap=18),
                'yAxis': axis, 'series': []}).classes('chart').props(
                    'data-chart={} role=img aria-label="{}"'.format(name, title))

    def _map(self) -> None:
        with card(self._t('map')):
            ui.element('canvas').classes('map').props(
                'role=img aria-label="{}"'.format(self._t('map_label')))
            ui.element('p').props('data-bind=pose aria-live=off')
            paragraph(self._t('map_help'))

    def _drive(self) -> None:
        driving = self._robot.driving
        with card(self._t('drive')):
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
            paragraph(self._t('drive_help'))
            self._limits: Dict[str, Slider] = {}
            for name in ('max_linear', 'max_angular'):
                field = name + '_velocity'
                highest = getattr(driving.settings, field)
                self._limits[field] = Slider(
                    self._t(name), highest / 20, highest, highest / 20, driving.limits[field],
                    partial(driving.limit, field))

    def _simulation(self) -> None:
        with card(self._t('simulation')):
            with ui.row().style('gap: 6px'):
                for action, key, icon in (('pause_physics', 'pause', 'pause'),
                                          ('unpause_physics', 'resume', 'play_arrow'),
                                          ('reset_world', 'reset_world', 'replay')):
                    button(icon, self._t(key), partial(wait_for, self._system.act, action))
                self._record_button = button('fiber_manual_record', self._t('record'),
                                             self._record)
            with ui.element('p'):
                ui.label(self._t('measured_factor') + ': ').style('display: inline')
                ui.label('').props('data-bind=factor').style('display: inline')
            # without a value until the simulator has told it
            self._factor = ui.select(
                self._factors(_FACTORS), label=self._t('factor'),
                on_change=self._on_factor).props('dense options-dense').style('width: 100%')
            self._view = ui.select(
                {'above': self._t('above'), 'follow': self._t('follow')},
                label=self._t('viewpoint'), on_change=self._on_view).props(
                    'dense options-dense').style('width: 100%')

    def _factors(self, values: Iterable[float]) -> Dict[float, str]:
        """Return the texts of real time factors, the highest last."""
        return {value: '{:g}'.format(value) if value else self._t('fastest')
                for value in sorted(values, key=lambda value: value or math.inf)}

    # what a visitor does

    async def _on_pose(self, event: Any) -> None:
        try:
            x, y, yaw = (float(event.args[key]) for key in ('x', 'y', 'yaw'))
        except (TypeError, ValueError, KeyError):
            return
        await wait_for(self._robot.set_pose, x, y, yaw)

    async def _record(self) -> None:
        is_running = self._is_recording         # or else two who stop would start one
        path = await self._recording_call.wait_for(self._system.record, not is_running)
        if path:
            ui.notify(self._t('recorded' if is_running else 'recording_to', path),
                      multi_line=True)

    def _on_factor(self, event: Any) -> None:
        if event.value not in (None, self._system.simulator.values().get('real_time_factor')):
            self._system.simulator.change(real_time_factor=float(event.value))

    def _on_view(self, event: Any) -> None:
        if event.value not in (None, self._system.simulator.values().get('view')):
            self._system.simulator.change(view=event.value)
