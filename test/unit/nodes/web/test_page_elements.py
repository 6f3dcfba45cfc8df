"""Sliders of the page, with NiceGUI's element and a stand-in for the browser."""
import asyncio

import pytest
from nicegui import Client, ui
from nicegui.events import GenericEventArguments

from img_recog.nodes.web import page_elements
from img_recog.nodes.web.page_elements import OneCall, Slider


class Visitor:
    """Moves a slider; `told` has the values that the browser gets from the node."""

    def __init__(self, monkeypatch):
        self.changes, self.told = [], []
        with Client(ui.page('/test')) as client:
            self.slider = Slider('hue', 0, 180, 1, 10, self.changes.append)
        self._client, self._element = client, self.slider.element
        monkeypatch.setattr(self._element, 'update',
                            lambda: self.told.append(self._element.value))

    def move(self, value):
        """What NiceGUI does when the browser says that the slider was moved."""
        for listener in self._element._event_listeners.values():
            listener.handler(GenericEventArguments(
                sender=self._element, client=self._client, args=value))


@pytest.fixture
def visitor(monkeypatch):
    """A visitor whose moves are settled at once."""
    monkeypatch.setattr(page_elements, 'SETTLE_S', 0.0)
    return Visitor(monkeypatch)


def test_an_answer_of_the_node_does_not_move_a_slider_back(visitor):
    for value in (11, 12, 13):
        visitor.move(value)
    assert visitor.changes == [11, 12, 13] and visitor.told == []


def test_while_it_is_moved_it_follows_nothing(visitor, monkeypatch):
    monkeypatch.setattr(page_elements, 'SETTLE_S', 1000.0)
    visitor.move(11)
    assert not visitor.slider.follow(12) and visitor.told == []


def test_afterwards_it_follows_what_something_else_sets(visitor):
    visitor.move(11)
    assert not visitor.slider.follow(10)
    assert visitor.slider.follow(10)
    # without the first one the browser, which was told 10 at the beginning, would see no change
    assert visitor.told == [11, 10]
    assert visitor.slider.follow(10) and visitor.told == [11, 10]
    assert visitor.slider.follow(9) and visitor.told == [11, 10, 9]


def test_it_is_settled_at_once_if_the_node_has_its_value(visitor):
    visitor.move(11)
    assert visitor.slider.follow(11) and visitor.told == [11]


@pytest.mark.parametrize('value', [-1, 181, 1e300, float('nan'), float('inf'), None, '11', [11]])
def test_a_value_that_the_slider_cannot_have_is_dropped(visitor, value):
    visitor.move(value)
    assert visitor.changes == []
    visitor.move(11)
    assert visitor.changes == [11]


def test_one_call_at_a_time_while_another_waits(monkeypatch):
    async def visit():
        is_free = asyncio.Event()       # made here: it belongs to the loop that runs
        begun = []

        async def wait_for(function, *arguments):
            begun.append(arguments)
            await is_free.wait()
            return function(*arguments)
        monkeypatch.setattr(page_elements, 'wait_for', wait_for)
        calls = OneCall()
        first = asyncio.ensure_future(calls.wait_for(abs, -1))
        second = asyncio.ensure_future(calls.wait_for(abs, -2))
        await asyncio.sleep(0)
        dropped = await calls.wait_for(abs, -3)
        assert begun == [(-1,)]
        is_free.set()
        return dropped, await first, await second, await calls.wait_for(abs, -4)
    assert asyncio.run(visit()) == (None, 1, 2, 4)
