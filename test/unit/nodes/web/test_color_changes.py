"""What a visitor takes back, with a stand-in for the parameters of the node."""
import asyncio

import pytest

from img_recog.nodes.web import page_elements
from img_recog.nodes.web.colors_tab import ColorChanges


class Colors:
    """Parameters that are changed at once."""

    def __init__(self):
        self.now = {'hue': 10, 'value': 20, 'limit': 30}

    def values(self):
        return self.now

    def change(self, **values):
        self.now = {**self.now, **values}

    def replace(self, changes):
        before = self.now
        self.change(**changes)
        return {name: before[name] for name in changes}


@pytest.fixture(autouse=True)
def wait_for(monkeypatch):
    """Calls are made at once, in this thread."""
    async def wait_for(function, *arguments):
        await asyncio.sleep(0)
        return function(*arguments)
    monkeypatch.setattr(page_elements, 'wait_for', wait_for)


def test_sliders_and_uses_are_taken_back_one_by_one():
    async def visit():
        colors = Colors()
        changes = ColorChanges(colors)
        for value in (11, 12, 13):      # one move
            changes.move('hue', value)
        changes.move('value', 21)
        changes.move('value', 22)
        await changes.use({'hue': 1, 'value': 2})
        changes.move('value', 3)
        seen = []
        while changes.steps:
            await changes.take_back()
            seen.append(dict(colors.now))
        await changes.take_back()       # nothing is left
        return seen, colors.now
    seen, last = asyncio.run(visit())
    assert [(each['hue'], each['value']) for each in seen] == [
        (1, 2), (13, 22), (13, 20), (10, 20)]
    assert last == Colors().now


def test_what_is_not_done_yet_is_taken_back():
    async def visit():
        colors = Colors()
        changes = ColorChanges(colors)
        changes.move('limit', 40)
        await asyncio.gather(changes.use({'hue': 1}), changes.take_back())
        return colors.now, bool(changes.steps)
    assert asyncio.run(visit()) == ({'hue': 10, 'value': 20, 'limit': 40}, True)


def test_a_slider_of_a_node_that_does_not_answer_is_no_step():
    colors = Colors()
    colors.now = {}
    changes = ColorChanges(colors)
    changes.move('hue', 11)
    assert not changes.steps and colors.now == {'hue': 11}
