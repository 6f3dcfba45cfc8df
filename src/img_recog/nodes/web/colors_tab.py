"""The tab with the bounds, limits and commands of the colors."""
import base64
import json
import shlex
from functools import partial
from typing import Any, Callable, Dict, List, Optional

from nicegui import ui

from img_recog.nodes.web.color_samples import SamplesState
from img_recog.nodes.web.page_elements import (OneCall, Slider, Visit, button, card, numbers,
                                               paragraph, picture, wait_for)
from img_recog.nodes.web.tuning import ColorTuning, color_names_in
from img_recog.recognition.fitting.bounds import as_parameters
from img_recog.recognition.fitting.marked import SAMPLES_FILE
from img_recog.recognition.fitting.offers import Offer
from img_recog.recognition.fitting.samples import NO_COLOR

# of each color: the end of the parameter's name, the least and greatest value, and the step
_SLIDERS = (
    ('hue_min', 0, 180, 1), ('hue_max', 0, 180, 1), ('saturation_min', 0, 255, 1),
    ('saturation_max', 0, 255, 1), ('value_min', 0, 255, 1), ('value_max', 0, 255, 1),
    ('area_limit', 0, 20000, 50), ('linear_x', -10, 10, 0.01), ('angular_z', -3, 3, 0.05))


class SampleCard:
    """The card of one visitor. All visitors share the samples; each has a picture of their own."""

    def __init__(self, visit: Visit, choice: Any, use: Callable):
        """Add its elements.

        choice: the element whose value is the chosen color; use: sets the parameters of an offer.
        """
        self._samples, self._t, self._use = visit.robot.samples, visit.texts, use
        self._choice, self._calls = choice, OneCall()
        self._picture = ''              # that is held; '' while it is live
        self._shown: Any = None
        with card(self._t('samples')):
            paragraph(self._t('mark'))
            self._list = ui.element('div').classes('samples')
            self._rest = ui.checkbox(self._t('rest'), value=True,
                                     on_change=self._set_rest).props('dense size=xs')
            self._offers = ui.element('div').classes('offers').props('role=status')
            with ui.element('div').classes('samples'):
                self._freeze = button('pause', self._t('freeze'), self._hold)
                button('save', self._t('save_samples'), self._save)
        self.update()

    async def mark(self, *place: float) -> None:
        """Add a sample in the picture; place: as ColorSamples.mark has it."""
        picture = await self._calls.wait_for(
            self._samples.mark, self._picture, self._choice.value, *place)
        if picture:
            await self._show(picture)

    def update(self) -> None:
        """Show what this page and others have changed."""
        state = self._samples.state
        if state is self._shown:
            return
        before, self._shown = self._shown, state
        self._offers.clear()
        with self._offers:
            if state.is_searching:
                paragraph(self._t('searching'))
            if state.problem:
                paragraph(state.problem)
            for color, offer in state.offers.items():
                self._offer(color, offer)
        if before is not None and before.marked[1:3] == state.marked[1:3]:
            return
        self._rest.value = state.marked.rest_is_none
        self._list_samples(state)

    def _list_samples(self, state: SamplesState) -> None:
        self._list.clear()
        with self._list:
            for each in state.marked.samples:
                color = self._t('no_color') if each.color == NO_COLOR else each.color
                button('close', self._t('sample', each.number, color, each.area_px),
                       partial(self._remove, each.number)).props(
                           'outline title="{0}" aria-label="{0}"'.format(
                               self._t('remove', each.number)))

    def _offer(self, color: str, offer: Offer) -> None:
        if offer.box is None:
            paragraph(offer.problem)
            return
        hue, saturation, value = offer.box
        paragraph(self._t('offered', color, *hue, *saturation, *value, offer.marked_inside,
                          offer.others_inside))
        button('check', self._t('use', color), partial(
            self._use, as_parameters(color, offer.box)))

    # what a visitor does

    async def _remove(self, number: int) -> None:
        await wait_for(self._samples.remove, number)
        await self._show(self._picture)

    async def _set_rest(self, event: Any) -> None:
        if bool(event.value) != self._samples.state.marked.rest_is_none:
            await wait_for(self._samples.set_rest, bool(event.value))

    async def _hold(self) -> None:
        """Hold the picture, or show the live one again."""
        picture = '' if self._picture else await self._calls.wait_for(self._samples.freeze)
        if picture is not None:
            await self._show(picture)

    async def _show(self, picture: str) -> None:
        """Show a picture with its samples; '' for the live one."""
        self._picture = picture
        self._freeze.text = self._t('live_picture' if picture else 'freeze')
        self._freeze.props('icon=' + ('play_arrow' if picture else 'pause'))
        if not picture:
            ui.run_javascript('holdPicture(null, [])')
            return
        shown = await wait_for(self._samples.shown, picture)
        if shown:
            ui.run_javascript('holdPicture({}, {})'.format(
                json.dumps(base64.b64encode(shown[0]).decode()), json.dumps(shown[1])))
        else:
            await self._show('')

    async def _save(self) -> None:
        path = await self._calls.wait_for(self._samples.save)
        if path:
            ui.notify(self._t('saved_samples', shlex.quote(path), SAMPLES_FILE), multi_line=True,
                      timeout=10000)


class ColorChanges:
    """What one visitor changes, and takes back. For the event loop."""

    def __init__(self, colors: ColorTuning):
        self._colors, self._calls = colors, OneCall()
        self.steps: List[Dict[str, Any]] = []       # what was before each change
        self._moved = ''

    def move(self, parameter: str, value: float) -> None:
        """Change a parameter, as often as its slider is moved; until another one is, in one step.
        """
        values = self._colors.values()
        if parameter != self._moved and parameter in values:
            self.steps.append({parameter: values[parameter]})
        self._moved = parameter
        self._colors.change(**{parameter: value})

    async def use(self, values: Dict[str, Any]) -> None:
        """Change parameters together."""
        before = await self._calls.wait_for(self._colors.replace, values)
        if before:
            self._moved = ''
            self.steps.append(before)

    async def take_back(self) -> None:
        """Set back the last step, also one that is not done yet."""
        self._moved = ''
        await self._calls.wait_for(
            lambda: self.steps and self._colors.replace(self.steps.pop()))


class ColorsTab:
    """The tab of one visitor. The picture of one color is shown: of the one that is chosen."""

    def __init__(self, visit: Visit):
        """Add its elements; the sliders follow as soon as the node answers."""
        self._visit, self._colors, self._t = visit, visit.robot.colors, visit.texts
        self._calls = OneCall()
        self._samples: Optional[SampleCard] = None
        self._changes = ColorChanges(self._colors)
        self._sliders: Dict[str, Slider] = {}
        self._masks: Dict[str, Any] = {}
        self._revision = -1
        self._choice: Any = None
        with ui.element('div').classes('tuning'):
            with ui.element('div').classes('column-cards in-sight'):
                for each in visit.pictures:
                    if each.title == 'camera':
                        picture(self._t, each, 'pick')
                    elif each.title == 'mask':
                        self._masks[each.color] = picture(self._t, each)
                self._at_hand = ui.element('div').classes('samples at-hand')
            self._tuning = ui.element('div').classes('column-cards')
        self._build({}, [])
        ui.on('mark', self._on_mark, throttle=0.2)

    def update(self) -> None:
        """Show what other pages and nodes have changed."""
        if self._samples is not None:
            self._samples.update()
        revision = self._colors.revision
        if revision == self._revision:
            return
        self._revision, values = revision, self._colors.values()
        names = color_names_in(values)
        if names != self._names:
            self._build(values, names)
        ui.run_javascript('window.limits = {}'.format(json.dumps(
            {name: values[name + '_area_limit'] for name in names})))
        for parameter, slider in self._sliders.items():
            if parameter in values and not slider.follow(values[parameter]):
                self._revision = -1     # later

    def _build(self, values: Dict[str, Any], names: List[str]) -> None:
        """Make the sliders of all colors."""
        self._names = names
        self._tuning.clear()
        self._at_hand.clear()
        self._sliders.clear()
        if self._samples is not None:
            self._samples = None
            ui.run_javascript('holdPicture(null, [])')
        with self._tuning:
            if not names:
                paragraph(self._t('no_recognition'))
                self._show_mask('')
                return
            chosen = self._choice.value if self._choice is not None else ''
            options = {**{name: name for name in names}, NO_COLOR: self._t('no_color')}
            self._choice = ui.toggle(
                options, value=chosen if chosen in options else names[0]).props(
                    'dense no-caps role=group aria-label="{}"'.format(self._t('colors')))
            self._choice.on_value_change(lambda event: self._show_mask(event.value))
            self._show_mask(self._choice.value)
            self._samples = SampleCard(self._visit, self._choice, self._changes.use)
            paragraph(self._t('touched'))
            for name in names:
                section = card(name)
                for touch in ('pointerdown', 'focusin'):
                    section.on(touch, partial(self._choice.set_value, name), args=[])
                with section, ui.element('div').classes('sliders'):
                    for part, low, high, step in _SLIDERS:
                        self._slider(name, part, low, high, step, values)
        with self._at_hand:
            button('save', self._t('save'), self._save)
            button('undo', self._t('undo'), self._changes.take_back).bind_visibility_from(
                self._changes, 'steps', bool)

    def _show_mask(self, color: str) -> None:
        if color == NO_COLOR:       # the last one stays
            return
        for name, shown in self._masks.items():
            shown.set_visibility(name == color)

    def _slider(self, color: str, part: str, low: float, high: float, step: float,
                values: Dict[str, Any]) -> None:
        parameter, title = '{}_{}'.format(color, part), self._t(part)
        is_whole = isinstance(values[parameter], int)

        def change(value: float) -> None:
            self._changes.move(parameter, int(value) if is_whole else float(value))
        self._sliders[parameter] = Slider(title, low, high, step, values[parameter], change,
                                          'hue' if part.startswith('hue') else '',
                                          '{}: {}'.format(color, title))

    async def _on_mark(self, event: Any) -> None:
        place = numbers(event, 'x', 'y', 'width', 'height') or numbers(event, 'x', 'y')
        if self._samples is None:
            ui.notify(self._t('no_recognition'), type='negative')
        elif place:
            await self._samples.mark(*place)

    async def _save(self) -> None:
        path = await self._calls.wait_for(self._colors.save)
        if path:
            ui.notify(self._t('saved', shlex.quote(path)), multi_line=True, timeout=10000)
