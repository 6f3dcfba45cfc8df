"""The tab with pictures, charts, map, drive buttons and the simulation."""
import math
import os
import subprocess
import tempfile
from functools import partial
from typing import Any, Dict, Iterable, Sequence, Tuple

from nicegui import app, ui

from img_recog.errors import UserError, one_line
from img_recog.nodes.web import simulation_service
from img_recog.nodes.web.page_elements import (OneCall, Slider, Visit, button, card, numbers,
                                               paragraph, picture, wait_for)

TIMEOUT_S = 120.0
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


def draw(path: str, robot: str, colors: str) -> str:
    """Draw the drive of a robot in a bag; return the path of the picture, beside the bag.

    robot: its namespace, '' for the only one. colors: the text of a parameter file, '' for those
    of the article. Waits: not for the event loop. Raises UserError if it cannot be drawn.
    """
    output = os.path.splitext(path)[0] + '.png'
    words = ['rosrun', 'img_recog', 'plot.py', path, output]
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
        file.write(colors)
        file.flush()
        words += ['--robot', robot] if robot else []
        words += ['--colors', file.name] if colors else []
        try:
            done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, timeout=TIMEOUT_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise UserError('no picture of {}: {}'.format(path, one_line(error)))
    if done.returncode:
        lines = done.stderr.decode(errors='replace').split('\n')
        reason = next((line for line in reversed(lines) if line.strip()),
                      'exit code {}'.format(done.returncode))
        raise UserError(reason.replace('plot.py: error: ', ''))
    return output


class LiveTab:
    """The tab of one visitor."""

    def __init__(self, visit: Visit):
        """Add its elements."""
        self._shared, self._robot, self._t = visit.shared, visit.robot, visit.texts
        self._recording_call, self._is_recording = OneCall(), False     # what the button says
        self._picture_call = OneCall()
        with ui.element('div').classes('board'):
            with ui.element('div').classes('column-cards'):
                with ui.element('div').classes('pictures'):
                    for each in visit.pictures:
                        self._show_with(each.topic, picture(self._t, each))
                self._show_with(self._robot.resolve('color_detection'),
                                self._chart('areas', type='log', min=1))
            with ui.element('div').classes('column-cards'):
                self._map()
                self._chart('speeds')
            with ui.element('div').classes('column-cards'):
                self._drive()
                self._simulation()
        with ui.element('div').classes('stick').props(
                'data-stick role=img aria-label="{}"'.format(self._t('joystick'))):
            ui.element('div').classes('knob')
        ui.on('pose', self._on_pose, throttle=0.2)

    def _show_with(self, topic: str, element: Any) -> None:
        """Hide an element until its topic is published for the first time."""
        element.bind_visibility_from(self._shared.robots, 'seen', lambda seen: topic in seen)

    def update(self) -> None:
        """Show what other pages and nodes have changed."""
        self._is_recording = is_recording = bool(self._shared.recorder.path)
        self._record_button.props('color=' + ('negative' if is_recording else 'primary'))
        self._record_button.text = self._t('stop_recording' if is_recording else 'record')
        simulator = self._shared.simulator.values()
        if simulator.get('view') in self._view.options:
            self._view.value = simulator['view']
        factor = simulator.get('real_time_factor')
        if factor is not None and factor != self._factor.value:
            self._factor.set_options(self._factors({*_FACTORS, factor}), value=factor)
        limits = self._robot.driving.limits
        for field, slider in self._limits.items():
            slider.follow(limits[field])

    def _chart(self, name: str, **y_axis: Any) -> Any:
        title = self._t(name)
        section = card(title)
        with section:
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
                'yAxis': {**axis, **y_axis}, 'series': []}).classes('chart').props(
                    'data-chart={} role=img aria-label="{}"'.format(name, title))
        return section

    def _map(self) -> None:
        with card(self._t('map')):
            ui.element('canvas').classes('map').props(
                'data-event=pose role=img aria-label="{}"'.format(self._t('map_label')))
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
                    ui.button(icon=icon, color='negative' if key == 'stop' else 'primary').props(
                        'data-drive="{}" aria-label="{}" title="{}"'.format(
                            direction, self._t(key), self._t(key)))
            ui.element('p').props('data-bind=busy role=status')
            paragraph(self._t('drive_help'))
            self._show_with(self._robot.resolve('color_detection'),
                            paragraph(self._t('colors_again')))
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
                    button(icon, self._t(key), partial(wait_for, simulation_service.call, action))
                self._record_button = button('fiber_manual_record', self._t('record'),
                                             self._record)
            self._drive_picture = ui.link(self._t('drive_picture'), new_tab=True)
            self._drive_picture.set_visibility(False)
            with ui.element('p'):
                ui.label(self._t('measured_factor') + ': ').style('display: inline')
                ui.label('').props('data-bind=factor').style('display: inline')
            # without a value until the simulator has told it
            self._factor = self._choice('real_time_factor', 'factor', self._factors(_FACTORS))
            self._view = self._choice('view', 'viewpoint', {
                'above': self._t('above'), 'follow': self._t('follow')})

    def _choice(self, parameter: str, label: str, options: Dict[Any, str]) -> ui.select:
        """Add a choice of the value of a parameter of the simulator."""
        return ui.select(options, label=self._t(label), on_change=partial(
            self._change, parameter)).props('dense options-dense').style('width: 100%')

    def _factors(self, values: Iterable[float]) -> Dict[float, str]:
        """Return the texts of real time factors, the highest last."""
        return {value: '{:g}'.format(value) if value else self._t('fastest')
                for value in sorted(values, key=lambda value: value or math.inf)}

    # what a visitor does

    async def _on_pose(self, event: Any) -> None:
        place = numbers(event, 'x', 'y', 'yaw')
        if place:
            await wait_for(self._robot.pose.publish, *place)

    async def _record(self) -> None:
        is_running = self._is_recording         # or else two who stop would start one
        path = await self._recording_call.wait_for(self._shared.recorder.record, not is_running)
        if path:
            ui.notify(self._t('recorded' if is_running else 'recording_to', path),
                      multi_line=True)
        if path and is_running:
            await self._draw(path)

    async def _draw(self, path: str) -> None:
        """Show a link to the picture of a recording."""
        robot = self._robot.resolve('odom')[:-len('odom')].strip('/')
        picture = await self._picture_call.wait_for(lambda: draw(
            path, robot, self._robot.colors.as_file()))
        if picture:
            self._drive_picture.props('href=' + app.add_static_file(
                local_file=picture, max_cache_age=0))
            self._drive_picture.set_visibility(True)

    def _change(self, parameter: str, event: Any) -> None:
        if event.value not in (None, self._shared.simulator.values().get(parameter)):
            self._shared.simulator.change(**{parameter: event.value})
