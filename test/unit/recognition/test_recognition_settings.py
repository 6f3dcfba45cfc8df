"""Settings of the recognition: defaults, colors, and refused values."""
import dataclasses

import pytest

from img_recog.recognition.recognition_settings import Color, color_in, color_names, with_colors
from img_recog.settings import SettingError


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


@pytest.mark.parametrize('values, text', [
    ({'blue_hue_min': -1}, 'blue_hue_min: got -1, allowed is a whole number from 0 to 180'),
    ({'blue_hue_max': 181}, 'blue_hue_max: got 181, allowed is a whole number from 0 to 180'),
    ({'red_value_max': 256}, 'red_value_max: got 256, allowed is a whole number from 0 to 255'),
    ({'red_value_min': 1.5}, 'red_value_min: got 1.5, allowed is a whole number from 0 to 255'),
    ({'red_row_min': 0.6, 'red_row_max': 0.5},
     'red_row_min: got 0.6, allowed is at most red_row_max, which is 0.5'),
    ({'red_column_max': 1.5}, 'red_column_max: got 1.5, allowed is a finite number from 0 to 1'),
    ({'blue_saturation_min': 200, 'blue_saturation_max': 150},
     'blue_saturation_min: got 200, allowed is at most blue_saturation_max, which is 150'),
    ({'red_value_max': 149}, 'red_value_min: got 150, allowed is at most red_value_max, which is '
     '149'),
    ({'blue_area_limit': -1}, 'blue_area_limit: got -1, allowed is a whole number at least 0'),
    ({'blue_linear_x': float('nan')}, 'blue_linear_x: got nan, allowed is a finite number'),
    ({'stop_when_lost': -0.1},
     'stop_when_lost: got -0.1, allowed is a finite number at least 0'),
    ({'roi_width': -1}, 'roi_width: got -1, allowed is a whole number at least 0')])
def test_refused_values(values, text):
    with pytest.raises(SettingError) as caught:
        with_colors()(**values)
    assert str(caught.value) == text


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
