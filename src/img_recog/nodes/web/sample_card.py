"""The card in which samples of colors are marked, and the bounds that are offered for them."""
import base64
import json
import shlex
from functools import partial
from typing import Any, Callable

from nicegui import ui

from img_recog.nodes.web.color_samples import SamplesState
from img_recog.nodes.web.page_elements import (
    OneCall, Visit, button, card, paragraph, wait_for)
from img_recog.recognition.fitting.bounds import as_parameters
from img_recog.recognition.fitting.marked import SAMPLES_FILE
from img_recog.recognition.fitting.offers import Offer
from img_recog.recognition.fitting.samples import NO_COLOR


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
