"""Areas to commands, with the article's rules and others."""
import pytest

from img_recog.recognition.commands import commands
from img_recog.recognition.settings import BLUE, RED, RULES, ColorRule


def test_rules_are_the_articles():
    assert RULES == (BLUE, RED)
    assert (BLUE.color.name, BLUE.color.lower, BLUE.color.upper) == (
        'blue', (50, 100, 100), (150, 255, 255))
    assert (RED.color.name, RED.color.lower, RED.color.upper) == (
        'red', (150, 100, 150), (180, 255, 255))
    assert (BLUE.area_limit_px, BLUE.linear_x) == (1000, 10.0)
    assert (RED.area_limit_px, RED.linear_x) == (1000, -10.0)


@pytest.mark.parametrize('blue_px, red_px, expected', [
    (0, 0, []),
    (1000, 1000, []),
    (1001, 1000, [10.0]),
    (1000, 1001, [-10.0]),
    (1001, 1001, [10.0, -10.0]),
    (307200, 0, [10.0]),
    (0, 307200, [-10.0])])
def test_one_command_for_each_colour_above_its_limit_blue_first(blue_px, red_px, expected):
    assert commands([blue_px, red_px], RULES) == expected


def test_order_and_limits_are_those_of_the_rules():
    rules = (ColorRule(RED.color, 5, -1.0), ColorRule(BLUE.color, 50, 2.0))
    assert commands([6, 51], rules) == [-1.0, 2.0]
    assert commands([6, 50], rules) == [-1.0]
    assert commands([5, 51], rules) == [2.0]


def test_no_rules_give_no_commands():
    assert commands([], ()) == []
