"""The tab with the bounds, limits and commands of the colors."""
import json
from typing import Any, Dict, List, Sequence

from nicegui import ui

from img_recog.nodes.web.elements import OneCall, Slider, card, paragraph, picture
from img_recog.nodes.web.system import PictureTopic, Robot
from img_recog.nodes.web.texts import Texts
from img_recog.nodes.web.tuning import color_names_in

_PICTURES = 3


class ColorsTab:
    """The tab of one visitor."""

    def __init__(self, robot: Robot, texts: Texts, pictures: List[PictureTopic]):
        """Add its elements; the sliders follow as soon as the node answers."""
        self._robot, self._t, self._calls = robot, texts, OneCall()
        self._sliders: Dict[str, Slider] = {}
        self._revision = -1
        self._picked = ''
        with ui.element('div').classes('tuning'):
            with ui.element('div').classes('column-cards'):
                for topic, title, color in pictures[:_PICTURES]:
                    picture(topic, texts(title, color), texts('no_image'),
                            'pick' if title == 'camera' else '')
            self._tuning = ui.element('div').classes('column-cards')
        self._build({}, [])
        ui.on('pick', self._on_pick, throttle=0.2)

    def update(self) -> None:
        """Show what other pages and nodes have changed."""
        revision = self._robot.colors.revision
        if revision == self._revision:
            return
        self._revision, values = revision, self._robot.colors.values()
        names = color_names_in(values)
        if [name + '_hue_min' for name in names] != [
                each for each in self._sliders if each.endswith('_hue_min')]:
            self._build(values, names)
        ui.run_javascript('window.limits = {}'.format(json.dumps(
            {name: values[name + '_area_limit'] for name in names})))
        for parameter, slider in self._sliders.items():
            if parameter in values and not slider.follow(values[parameter]):
                self._revision = -1     # later

    def _build(self, values: Dict[str, Any], names: Sequence[str]) -> None:
        """Make the sliders of all colors."""
        self._tuning.clear()
        self._sliders.clear()
        with self._tuning:
            if not names:
                paragraph(self._t('no_recognition'))
                return
            self._picked = self._picked if self._picked in names else names[0]
            ui.toggle({name: name for name in names}, value=self._picked,
                      on_change=lambda event: setattr(self, '_picked', event.value)).props(
                          'dense no-caps role=group aria-label="{}"'.format(self._t('colors')))
            paragraph(self._t('pick'))
            for name in names:
                with card(name), ui.element('div').classes('sliders'):
                    self._color(name, values)
            ui.button(self._t('save'), icon='save', on_click=self._save).props('no-caps')

    def _color(self, name: str, values: Dict[str, Any]) -> None:
        for bound in ('hue_min', 'hue_max'):
            self._slider(name, bound, 0, 180, 1, values, 'hue')
        for bound in ('saturation_min', 'saturation_max', 'value_min', 'value_max'):
            self._slider(name, bound, 0, 255, 1, values)
        self._slider(name, 'area_limit', 0, 20000, 50, values)
        self._slider(name, 'linear_x', -10, 10, 0.01, values)
        self._slider(name, 'angular_z', -3, 3, 0.05, values)

    def _slider(self, color: str, part: str, low: float, high: float, step: float,
                values: Dict[str, Any], classes: str = '') -> None:
        parameter, title = '{}_{}'.format(color, part), self._t(part)
        is_whole = isinstance(values[parameter], int)

        def change(value: float) -> None:
            self._robot.colors.change(**{parameter: int(value) if is_whole else float(value)})
        self._sliders[parameter] = Slider(title, low, high, step, values[parameter], change,
                                          classes, '{}: {}'.format(color, title))

    async def _on_pick(self, event: Any) -> None:
        try:
            topic, (x, y) = str(event.args['topic']), (float(event.args[key]) for key in 'xy')
        except (TypeError, ValueError, KeyError):
            return
        color = self._picked
        bounds = await self._calls.wait_for(self._robot.propose, topic, x, y, color)
        if bounds:
            ui.notify(self._t('proposed', color, bounds['hue_min'], bounds['hue_max']))

    async def _save(self) -> None:
        path = await self._calls.wait_for(self._robot.save_colors)
        if path:
            ui.notify(self._t('saved', path), multi_line=True, timeout=10000)
