"""Where tools/place_windows.py places the windows."""
import importlib.util
import os

import pytest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))


@pytest.fixture(scope='module')
def tool():
    path = os.path.join(ROOT, 'tools')
    spec = importlib.util.spec_from_file_location(
        'place_windows', os.path.join(path, 'place_windows.py'))
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(path)
        spec.loader.exec_module(module)
    return module


def test_windows_that_have_room_cover_no_other(tool):
    assert tool.free_place((1100, 800), (500, 390), []) == (0, 0)
    assert tool.free_place((1100, 800), (500, 390), [(0, 0, 500, 390)]) == (0, 394)
    assert tool.free_place((1100, 800), (500, 390), [(0, 0, 500, 390), (0, 394, 500, 390)]) == (
        504, 0)


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
