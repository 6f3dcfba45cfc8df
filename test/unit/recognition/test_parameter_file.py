"""Reading a parameter file, and the files that are refused."""
import os

import pytest

from img_recog.recognition import parameter_file
from img_recog.recognition.recognition_settings import Color, with_colors
from img_recog.settings import ParameterError
from img_recog_helpers import expected
from img_recog_helpers.refusals import refusal

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


def test_refused_files(tmp_path):
    expected.check_cases('refused/colors.txt', lambda text: refusal(
        parameter_file.read, written(tmp_path, text)).replace('{}/'.format(tmp_path), ''))


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
