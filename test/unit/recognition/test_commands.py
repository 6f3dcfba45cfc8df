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


STOPS, CHANGES = {'stop_when_lost': 0.5}, {'publish_on_change': True}


# areas, None for no image; when; and the commands
@pytest.mark.parametrize('values, steps', [
    ({}, [(BLUE, 10, [FORWARD]), (BLUE, 10, [FORWARD]), (NONE, 10, []),
          (BOTH, 10, [FORWARD, BACKWARD]), (BOTH, 10, [FORWARD, BACKWARD]), (RED, 10, [BACKWARD]),
          (None, 1e6, []), (NONE, 2e6, [])]),
    (CHANGES, [(NONE, 10, []), (BLUE, 10, [FORWARD]), (BLUE, 10, []),
               (BOTH, 10, [FORWARD, BACKWARD]), (BOTH, 10, []), (RED, 10, [BACKWARD]),
               (NONE, 10, []), (NONE, 10, []), (RED, 10, [BACKWARD])]),
    (STOPS, [(BLUE, 10.1, [FORWARD]), (NONE, 10.2, []), (NONE, 10.55, []), (NONE, 10.61, [STOP]),
             (NONE, 10.7, []), (NONE, 20.0, []), (RED, 20.1, [BACKWARD]), (NONE, 20.7, [STOP])]),
    (STOPS, [(BLUE, 10.1, [FORWARD]), (None, 10.2, []), (None, 10.59, []), (None, 10.61, [STOP]),
             (None, 10.7, []), (None, 30.0, [])]),
    (STOPS, [(None, 10.4, []), (None, 10.5, [STOP]), (None, 10.6, [])]),
    ({**STOPS, **CHANGES}, [(BLUE, 10.1, [FORWARD]), (BLUE, 10.2, []), (None, 10.8, [STOP]),
                            (BLUE, 10.9, [FORWARD])])],
    ids=['default', 'on change', 'no color is seen', 'no image', 'no color was ever seen',
         'the same command after a stop'])
def test_commands_of_one_frame_after_the_other(values, steps):
    commander = Commander(settings(**values), 10.0)
    for areas, now_s, commands in steps:
        found = commander.wait(now_s) if areas is None else commander.decide(areas, now_s)
        assert found == commands, now_s
    assert commander.end() == [STOP] * ('stop_when_lost' in values)


def test_commands_of_the_newest_frame_are_known_even_if_they_are_not_published():
    commander = Commander(settings(publish_on_change=True), 0.0)
    assert commander.frame_commands == []
    seen = []
    for areas in (BLUE, BLUE, BOTH, NONE):
        commander.decide(areas, 0.0)
        seen.append(commander.frame_commands)
    assert seen == [[FORWARD], [FORWARD], [FORWARD, BACKWARD], []]


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


def test_other_settings_apply_at_once():
    commander = Commander(settings(), 0.0)
    assert commander.wait(100.0) == []
    commander.configure(settings(stop_when_lost=1.0, blue_linear_x=0.1))
    assert commander.decide(BLUE, 100.1) == [Command(0.1)]
    assert commander.wait(101.2) == [STOP]
