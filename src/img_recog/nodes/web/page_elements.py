"""What the tabs of a page get to know, and elements that several of them have."""
import asyncio
import itertools
import time
from typing import Any, Callable, List, NamedTuple

from nicegui import run, ui

from img_recog.errors import UserError, one_line
from img_recog.nodes.web.page_texts import Texts
from img_recog.nodes.web.shown_robots import PictureTopic, ShownRobot, ShownRobots
from img_recog.nodes.web.tuning import Tuning
from img_recog.processes.bag_recording import RecordingSwitch

_SLIDER_THROTTLE_S = 0.05
SETTLE_S = 1.0         # a slider that is moved is ahead of its value for this time
_numbers = itertools.count()


class Shared(NamedTuple):
    """What all pages share. simulator: its parameters."""

    robots: ShownRobots
    simulator: Tuning
    recorder: RecordingSwitch


class Visit(NamedTuple):
    """A page of a visitor, for one robot. pictures: those that it can show."""

    shared: Shared
    robot: ShownRobot
    texts: Texts
    pictures: List[PictureTopic]


def card(title: str) -> Any:
    """Return the context of a card with this heading."""
    heading = 'card-{}'.format(next(_numbers))
    section = ui.element('section').classes('card').props('aria-labelledby=' + heading)
    with section, ui.element('h2').props('id=' + heading):
        ui.label(title)
    return section


def paragraph(text: str) -> Any:
    """Add a paragraph; return it."""
    added = ui.element('p')
    with added:
        ui.label(text)
    return added


def picture(texts: Texts, shown: PictureTopic, classes: str = '') -> Any:
    """Add the picture of a topic; return its card."""
    title = texts(shown.title, shown.color)
    section = card(title)
    with section, ui.element('div').classes('picture'):
        ui.element('canvas').classes(classes).props(
            'data-picture="{}" role=img aria-label="{}"'.format(shown.topic, title))
        with ui.element('div').classes('empty'):
            ui.label(texts('no_image'))
        ui.element('div').classes('age').props('aria-live=off')
    return section


def numbers(event: Any, *keys: str) -> List[float]:
    """Return what an event has by these keys, empty if it is no numbers: browsers send anything.
    """
    try:
        return [float(event.args[key]) for key in keys]
    except (TypeError, ValueError, KeyError, OverflowError):
        return []


def button(icon: str, label: str, on_click: Callable) -> Any:
    """Return a small button with an icon and a text."""
    return ui.button(label, icon=icon, on_click=on_click).props('dense no-caps size=sm')


class _LocalSlider(ui.slider):
    """A slider that only the browser moves when the visitor does.

    NiceGUI's own is moved by the answer of the node, too: back, between two presses of a key.
    """

    LOOPBACK = None


class Slider:
    """A slider with its title and value. element: NiceGUI's."""

    def __init__(self, title: str, low: float, high: float, step: float, value: float,
                 change: Callable[[float], None], classes: str = '', label: str = ''):
        """Add it; change: is called while it is moved; label: for screen readers."""
        self._change, self._moved_s, self._is_ahead = change, -SETTLE_S, False
        self._low, self._high = low, high
        with ui.element('div').classes('slider-row'):
            ui.label(title)
            shown = ui.label()
            self.element = _LocalSlider(min=low, max=high, step=step, value=value).classes(
                classes).props('aria-label="{}"'.format(label or title))
            shown.bind_text_from(self.element, 'value', _number_text)
            self.element.on('update:model-value', lambda event: self._move(event.args),
                            throttle=_SLIDER_THROTTLE_S)

    def follow(self, value: float) -> bool:
        """Show a value that something else has set; return False while the visitor moves it."""
        if time.monotonic() - self._moved_s < SETTLE_S:
            return False
        if self._is_ahead:      # the browser must know its own value to notice another one
            self._is_ahead = False
            self.element.update()
            return self.element.value == value
        self.element.value = value
        return True

    def _move(self, value: float) -> None:
        # a browser may send anything
        if not (_is_number(value) and self._low <= value <= self._high):
            return
        self._moved_s, self._is_ahead = time.monotonic(), True
        self._change(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float))


def _number_text(value: Any) -> str:
    return '{:g}'.format(value) if _is_number(value) else ''


class OneCall:
    """Makes one call at a time: each may hold one of few threads for some seconds."""

    def __init__(self) -> None:
        self._count, self._lock = 0, asyncio.Lock()

    async def wait_for(self, function: Callable, *arguments: Any) -> Any:
        """Do what `wait_for` does, after the last call; nothing if another one waits already."""
        if self._count > 1:
            return None
        self._count += 1
        try:
            async with self._lock:
                return await wait_for(function, *arguments)
        finally:
            self._count -= 1


async def wait_for(function: Callable, *arguments: Any) -> Any:
    """Call a function in a thread; show its UserError, and return None then."""
    try:
        return await run.io_bound(function, *arguments)
    except UserError as error:
        ui.notify(one_line(error), type='negative')
        return None
