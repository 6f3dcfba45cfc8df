"""Commands for areas, by the article's rules and by other settings."""
import pytest

from img_recog.recognition.commands import STOP, Command, Commander, commands_for
from img_recog.recognition.recognition_settings import with_colors

FORWARD, BACKWARD = Command(10.0), Command(-10.0)
BLUE, RED, NONE, BOTH = [2000, 0], [0, 2000], [0, 0], [2000, 2000]


def settings(**values):
    return with_colors()(**values)


@pytest.mark.parametrize('blue_px, red_px, expected', [
    (0, 0, []),
    (1000, 1000, []),
    (1001, 1000, [FORWARD]),
    (1000, 1001, [BACKWARD]),
    (1001, 1001, [FORWARD, BACKWARD]),
    (307200, 0, [FORWARD]),
    (0, 307200, [BACKWARD])])
def test_one_command_for_each_color_above_its_limit_blue_first(blue_px, red_px, expected):
    assert commands_for([blue_px, red_px], settings()) == expected


def test_order_limits_and_commands_are_those_of_the_settings():
    other = with_colors(['red', 'green', 'blue'])(
        red_area_limit=5, red_linear_x=-1.0, green_hue_min=40, green_hue_max=80,
        green_angular_z=0.5, blue_area_limit=0)
    assert commands_for([6, 1001, 1], other) == [Command(-1.0), Command(0.0, 0.5), FORWARD]
    assert commands_for([5, 1000, 0], other) == []


@pytest.mark.parametrize('publish, blue_and_red, red, changed', [
    ('last', [BACKWARD], [BACKWARD], []),
    ('sum', [Command(-7.0, 0.75)], [BACKWARD], [BACKWARD])])
def test_one_command_for_a_frame(publish, blue_and_red, red, changed):
    values = {'publish_commands': publish, 'blue_linear_x': 3.0, 'blue_angular_z': 0.75}
    commander = Commander(settings(**values, stop_when_lost=0.5), 0.0)
    assert commander.decide(BOTH, 0.1) == commander.frame_commands == blue_and_red
    assert commander.decide(RED, 0.2) == red
    assert commander.decide(NONE, 0.3) == [] and commander.decide(NONE, 0.8) == [STOP]
    commander = Commander(settings(**values, publish_on_change=True), 0.0)
    assert commander.decide(BOTH, 0.1) == blue_and_red and commander.decide(RED, 0.2) == changed


def test_by_default_every_frame_has_its_commands_and_there_is_no_stop():
    commander = Commander(settings(), 0.0)
    assert [commander.decide(areas, 0.0) for areas in (BLUE, BLUE, NONE, BOTH, BOTH, RED)] == [
        [FORWARD], [FORWARD], [], [FORWARD, BACKWARD], [FORWARD, BACKWARD], [BACKWARD]]
    assert commander.wait(1e6) == commander.decide(NONE, 2e6) == commander.end() == []


def test_commands_of_the_newest_frame_are_known_even_if_they_are_not_published():
    commander = Commander(settings(publish_on_change=True), 0.0)
    assert commander.frame_commands == []
    seen = []
    for areas in (BLUE, BLUE, BOTH, NONE):
        commander.decide(areas, 0.0)
        seen.append(commander.frame_commands)
    assert seen == [[FORWARD], [FORWARD], [FORWARD, BACKWARD], []]


def test_publish_on_change():
    commander = Commander(settings(publish_on_change=True), 0.0)
    frames = (NONE, BLUE, BLUE, BOTH, BOTH, RED, NONE, NONE, RED)
    assert [commander.decide(areas, 0.0) for areas in frames] == [
        [], [FORWARD], [], [FORWARD, BACKWARD], [], [BACKWARD], [], [], [BACKWARD]]


def test_commands_that_were_dropped_are_due_again():
    commander = Commander(settings(publish_on_change=True, stop_when_lost=0.5), 10.0)
    for _ in range(2):
        assert commander.decide(BLUE, 10.1) == [FORWARD]
        commander.notify_dropped([FORWARD])
    assert commander.decide(BLUE, 10.2) == [FORWARD] and commander.decide(BLUE, 10.3) == []
    for now_s in (10.9, 11.0):
        assert commander.decide(NONE, now_s) == [STOP]
        commander.notify_dropped([STOP])
    assert commander.wait(11.1) == [STOP] and commander.wait(11.2) == []


def test_stop_once_when_no_color_is_seen():
    commander = Commander(settings(stop_when_lost=0.5), 10.0)
    assert commander.decide(BLUE, 10.1) == [FORWARD]
    assert commander.decide(NONE, 10.2) == commander.decide(NONE, 10.55) == []
    assert commander.decide(NONE, 10.61) == [STOP]
    assert commander.decide(NONE, 10.7) == commander.decide(NONE, 20.0) == []
    assert commander.decide(RED, 20.1) == [BACKWARD]
    assert commander.decide(NONE, 20.7) == [STOP]


def test_stop_once_when_the_image_is_stale():
    commander = Commander(settings(stop_when_lost=0.5), 10.0)
    assert commander.decide(BLUE, 10.1) == [FORWARD]
    assert [commander.wait(now) for now in (10.2, 10.59, 10.61, 10.7, 30.0)] == [
        [], [], [STOP], [], []]


def test_stop_when_no_color_was_ever_seen_and_on_shutdown():
    commander = Commander(settings(stop_when_lost=0.5), 10.0)
    assert [commander.wait(now) for now in (10.4, 10.5, 10.6)] == [[], [STOP], []]
    assert commander.end() == [STOP]


def test_the_same_command_after_a_stop_is_a_change():
    commander = Commander(settings(stop_when_lost=0.5, publish_on_change=True), 0.0)
    assert commander.decide(BLUE, 0.1) == [FORWARD]
    assert commander.decide(BLUE, 0.2) == []
    assert commander.wait(0.8) == [STOP]
    assert commander.decide(BLUE, 0.9) == [FORWARD]


def test_other_settings_apply_at_once():
    commander = Commander(settings(), 0.0)
    assert commander.wait(100.0) == []
    commander.configure(settings(stop_when_lost=1.0, blue_linear_x=0.1))
    assert commander.decide(BLUE, 100.1) == [Command(0.1)]
    assert commander.wait(101.2) == [STOP]
