"""Settings of the recognition: defaults, colors, and refused values."""
import dataclasses

import pytest
import yaml

from img_recog.recognition.recognition_settings import Color, color_in, color_names, with_colors
from img_recog.settings import SettingError
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal


def test_defaults_are_the_articles():
    settings = with_colors()()
    assert settings.colors == (
        Color('blue', (50, 150), (100, 255), (100, 255), 1000, 10.0, 0.0),
        Color('red', (150, 180), (100, 255), (150, 255), 1000, -10.0, 0.0))
    assert (settings.stop_when_lost, settings.publish_on_change, settings.min_blob_size,
            settings.publish_commands) == (0.0, False, 0, 'all')
    assert (settings.roi_x_offset, settings.roi_y_offset, settings.roi_width,
            settings.roi_height) == (0, 0, 0, 0)


def test_more_colors():
    settings = with_colors(['green', 'blue'])(green_hue_min=40, green_hue_max=80,
                                              green_linear_x=1, blue_area_limit=7)
    assert settings.colors == (
        Color('green', (40, 80), (100, 255), (100, 255), 1000, 1.0, 0.0),
        Color('blue', (50, 150), (100, 255), (100, 255), 7, 10.0, 0.0))


def test_replacing_a_field_leaves_the_original_unchanged():
    settings = with_colors()()
    assert dataclasses.replace(settings, red_hue_max=10).colors[1].hue == (150, 10)
    assert settings.colors[1].hue == (150, 180)


def test_refused_values():
    expected.check_cases('refused/color_settings.txt', lambda text: refusal(
        with_colors(), **yaml.safe_load(text)))


def test_hues_of_a_new_color_are_required():
    with pytest.raises(SettingError) as caught:
        with_colors(['blue', 'green'])(green_hue_min=40)
    assert str(caught.value) == (
        'green_hue_max: got nothing, allowed is a whole number from 0 to 180')


@pytest.mark.parametrize('value', [
    [], None, '', 'blue', {}, ['blue', 'blue'], ['blue', 3], ['dark blue'], ['/blue'], [''],
    ['_blue'], ['1st'], [['blue']]])
def test_refused_names(value):
    with pytest.raises(SettingError) as caught:
        color_names(value)
    assert caught.value.name == 'colors' and caught.value.value == value


def test_accepted_names():
    assert color_names(['red', 'light_blue2']) == ('red', 'light_blue2')


@pytest.mark.parametrize('parameter, color', [
    ('dark_red_hue_min', 'dark_red'), ('red_image_topic', 'red'), ('red_angular_z', 'red'),
    ('hue_min', None), ('colors', None), ('image_topic', None)])
def test_color_that_a_parameter_is_named_after(parameter, color):
    assert color_in(parameter) == color


@pytest.mark.parametrize('hue, middle', [((50, 150), 100), ((30, 30), 30), ((170, 20), 5),
                                         ((0, 180), 90), ((180, 0), 0)])
def test_middle_of_a_range_of_hues(hue, middle):
    color = with_colors()().colors[0]._replace(hue=hue)
    assert color.middle_hue == middle
