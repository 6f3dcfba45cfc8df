"""Reading a parameter file, and the files that are refused."""
import os

import pytest

from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import Color, with_colors
from img_recog.settings import ParameterError

CONFIG = os.path.join(os.path.dirname(__file__), '..', '..', '..', 'config', 'colors.yaml')


def written(tmp_path, text):
    path = tmp_path / 'colors.yaml'
    path.write_text(text)
    return str(path)


def test_the_file_of_the_demo_has_the_defaults():
    settings = parameter_file.read(CONFIG)
    assert settings.color_names == ('blue', 'red')
    assert settings.colors == with_colors()().colors
    assert repr(settings) == repr(with_colors()())


def test_another_file(tmp_path):
    settings = parameter_file.read(written(
        tmp_path, 'colors: [green, red]\ngreen_hue_min: 40\ngreen_hue_max: 80\n'
        'green_image_topic: g\nimage_transport: raw\nstop_when_lost: 0.5\n'))
    assert settings.colors == (Color('green', (40, 80), (100, 255), (100, 255), 1000, 0.0, 0.0),
                               with_colors()().colors[1])
    assert settings.stop_when_lost == 0.5


@pytest.mark.parametrize('text, words', [
    ('', 'got nothing, expected lines like colors: [blue, red]'),
    ('# a comment\n', 'got nothing'), ('- blue\n', 'got list'), ('blue', 'got str'),
    ('a: [', 'no YAML, line 1'), ('colors: []', 'parameter colors: got []'),
    ('colors:', 'parameter colors: got nothing'),
    ('colors: [green]', 'parameter green_hue_min: got nothing'),
    ('5: 6', 'got 5 where the name'),
    ('blue_linear_x: 1' + 400 * '0', 'allowed is a finite number, within 32 bits'),
    ('min_blob_size: 99999999999', 'allowed is a whole number at least 0, within 32 bits'),
    ('purple_hue_min: 3', 'there is no color purple, the colors are blue, red; add it to '
     'colors: [blue, red, purple]'),
    ('x' * 300 + '_hue_min: 3', 'there is no color {} ... {}, the'.format('x' * 33, 'x' * 12)),
    ('blue_hue_mim: 3', 'did you mean blue_hue_min?'),
    ('red_area_limit: -5', 'parameter red_area_limit: got -5, allowed is a whole number '
     'at least 0'),
    ('blue_value_min: 200\nblue_value_max: 100', 'parameter blue_value_min: got 200, allowed is '
     'at most blue_value_max, which is 100')])
def test_refused_files(tmp_path, text, words):
    path = written(tmp_path, text)
    with pytest.raises(ParameterError) as caught:
        parameter_file.read(path)
    assert words in str(caught.value) and path in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('name, reason', [
    ('none.yaml', 'none.yaml: No such file or directory'), ('', ': Is a directory')])
def test_a_missing_file(tmp_path, name, reason):
    with pytest.raises(ParameterError) as caught:
        parameter_file.read(str(tmp_path / name))
    assert str(caught.value).endswith(
        reason + '; give a parameter file of color_extract, like config/colors.yaml')


def test_parameters_of_the_node_alone_are_accepted(tmp_path):
    path = tmp_path / 'colors.yaml'
    path.write_text('colors: [blue]\ncolors_file: a\nimage_transport: raw\n'
                    'blue_image_topic: b\nblue_hue_min: 60\n')
    settings = parameter_file.read(str(path))
    assert settings.color_names == ('blue',) and settings.colors[0].hue == (60, 150)
