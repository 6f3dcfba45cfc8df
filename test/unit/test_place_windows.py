"""Where tools/place_windows.py places the windows."""
import importlib
import os

import pytest

from img_recog_testing.pages import ROOT


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(os.path.join(ROOT, 'tools'))
    return importlib.import_module('place_windows')


def test_rviz_covers_a_part_of_the_simulator_rather_than_the_images(tool):
    sizes = {tool.SIMULATOR: (1024, 768), **dict.fromkeys(tool.IMAGES, (400, 300)),
             'demo.rviz - RViz': (1020, 750)}
    found = tool.places((1920, 1080), sizes)
    assert found['demo.rviz - RViz'] == (0, 330)
    assert [found[title] for title in tool.IMAGES] == [(1028, 0), (1028, 304), (1028, 608)]


def test_a_window_does_not_hide_the_corner_of_another_one(tool):
    taken = [(0, 0, 300, 200)]
    assert tool.free_place((320, 240), (300, 200), taken) == (20, 40)
    # a screen that is smaller than the window
    assert tool.free_place((200, 100), (300, 200), taken) == (0, 0)
