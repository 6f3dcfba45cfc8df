"""Elements of the page that several tabs have."""
from typing import Any, Callable

from nicegui import run, ui

from img_recog.errors import UserError, one_line

_SLIDER_THROTTLE_S = 0.05


def card(title: str) -> Any:
    """Return the context of a card with this heading."""
    section = ui.element('section').classes('card')
    with section, ui.element('h2'):
        ui.label(title)
    return section


def paragraph(text: str) -> None:
    """Add a paragraph."""
    with ui.element('p'):
        ui.label(text)


def picture(topic: str, title: str, empty: str, classes: str = '') -> None:
    """Add the picture of a topic; empty: what it says before the first image."""
    with card(title), ui.element('div').classes('picture'):
        ui.element('canvas').classes(classes).props(
            'data-picture="{}" role=img aria-label="{}"'.format(topic, title))
        with ui.element('div').classes('empty'):
            ui.label(empty)


def button(icon: str, label: str, on_click: Callable) -> Any:
    """Return a small button with an icon and a text."""
    return ui.button(label, icon=icon, on_click=on_click).props('dense no-caps size=sm')


def slider(title: str, low: float, high: float, step: float, value: float,
           change: Callable[[float], None], classes: str = '') -> Any:
    """Return a slider with its title and value; change: is called while it is moved."""
    with ui.element('div').classes('slider-row'):
        ui.label(title)
        shown = ui.label()
        element = ui.slider(min=low, max=high, step=step, value=value).classes(classes).props(
            'aria-label="{}"'.format(title))
        shown.bind_text_from(element, 'value', lambda value: '{:g}'.format(value))
        element.on('update:model-value', lambda event: change(event.args),
                   throttle=_SLIDER_THROTTLE_S)
    return element


async def wait_for(function: Callable, *arguments: Any) -> Any:
    """Call a function in a thread; show its UserError, and return None then."""
    try:
        return await run.io_bound(function, *arguments)
    except UserError as error:
        ui.notify(one_line(error), type='negative')
        return None
