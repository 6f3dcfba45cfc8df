"""Calibration files: round trip, files of other programs, and errors that name file and entry."""
import dataclasses
import os
import re

import pytest
import yaml

from img_recog.camera import calibration_file
from img_recog.camera.calibration import Calibration, CalibrationError
from img_recog.errors import UserError
from img_recog_testing.calibrations import BROKEN, KNOWN, OTHER

# as written by camera_calibration_parsers with yaml-cpp: numbers such as 1e-05 have no point
FOREIGN = """\
image_width: 640
image_height: 480
camera_name: narrow
camera_matrix:
  rows: 3
  cols: 3
  data: [500, 0, 320, 0, 501, 240, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [1e-05, -2E-3, 0, 0, 0]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 501, 240, 0, 0, 0, 1, 0]}
"""


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / 'head_camera.yaml')


def refused_load(path, content):
    """Return the error line of loading a file with this content."""
    with open(path, 'wb') as file:
        file.write(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(CalibrationError) as refused:
        calibration_file.load(path)
    assert isinstance(refused.value, UserError)
    assert path in str(refused.value) and '\n' not in str(refused.value)
    return str(refused.value)


def with_entry(key, value):
    """Return FOREIGN with one entry replaced."""
    return yaml.safe_dump(dict(yaml.safe_load(FOREIGN), **{key: value}))


@pytest.mark.parametrize('known', [KNOWN, OTHER])
def test_round_trip_is_exact(path, known):
    calibration_file.save(path, known)
    assert calibration_file.load(path) == known


@pytest.mark.parametrize('name', ['', 'yes', '12', 'a: b', 'カメラ'])
def test_round_trip_of_names_that_yaml_could_read_as_another_type(path, name):
    named = Calibration(name, *[getattr(KNOWN, field) for field in (
        'width', 'height', 'distortion_model', 'distortion', 'camera_matrix', 'rectification',
        'projection')])
    calibration_file.save(path, named)
    assert calibration_file.load(path) == named


def test_file_of_another_program_is_read(path):
    with open(path, 'w') as file:
        file.write(FOREIGN)
    loaded = calibration_file.load(path)
    assert (loaded.camera_name, loaded.width, loaded.height) == ('narrow', 640, 480)
    assert loaded.distortion == (1e-05, -2e-3, 0.0, 0.0, 0.0)
    assert loaded.camera_matrix == (500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0)
    assert type(loaded.camera_matrix[0]) is float


def test_missing_file_is_a_separate_error(path):
    with pytest.raises(FileNotFoundError):
        calibration_file.load(path)


@pytest.mark.parametrize('content', [
    'a: [1, 2', 'a: b: c', '\tx: 1', b'\x00\x01\x02', b'\x89PNG\r\n\x1a\n\xff\xfe', b'\xff' * 99,
    FOREIGN.replace('narrow', '2020-13-45')])
def test_file_that_is_not_yaml(path, content):
    assert refused_load(path, content).startswith('cannot read calibration ' + path + ': ')


@pytest.mark.parametrize('content', ['', 'just words', '[1, 2]', '5'])
def test_yaml_without_entries(path, content):
    assert 'has no camera_matrix and other entries; write one with ' in refused_load(path, content)


def test_folder_instead_of_a_file(tmp_path):
    with pytest.raises(CalibrationError) as refused:
        calibration_file.load(str(tmp_path))
    assert str(refused.value).startswith('cannot read calibration {}: '.format(tmp_path))


@pytest.mark.parametrize('key', [
    'image_width', 'image_height', 'distortion_model', 'camera_matrix', 'rectification_matrix',
    'distortion_coefficients', 'projection_matrix'])
def test_missing_entry_is_named(path, key):
    content = yaml.safe_load(FOREIGN)
    del content[key]
    assert 'has no usable entry ' + key + ' (' in refused_load(path, yaml.safe_dump(content))


@pytest.mark.parametrize('key, value', [
    ('image_width', 'wide'), ('image_width', 640.5), ('image_width', True),
    ('image_height', float('inf')), ('image_height', None), ('image_height', [480]),
    ('distortion_model', 5), ('distortion_model', ['plumb_bob']),
    ('camera_matrix', 5), ('camera_matrix', [1.0] * 9), ('camera_matrix', 'none'),
    ('camera_matrix', {'data': [1.0] * 8 + ['one']}), ('camera_matrix', {'data': [None] * 9}),
    ('camera_matrix', {'data': '123456789'}), ('camera_matrix', {'rows': 3}),
    ('projection_matrix', {'data': [[1, 2, 3, 4]] * 12}),
    ('distortion_coefficients', {'data': [10 ** 400]})])
def test_entry_of_a_wrong_type_is_named(path, key, value):
    assert key in refused_load(path, with_entry(key, value)).split('no usable entry ')[1]


@pytest.mark.parametrize('key, wanted, has', [
    ('camera_matrix', 9, 8), ('camera_matrix', 9, 10), ('rectification_matrix', 9, 0),
    ('projection_matrix', 12, 9)])
def test_wrong_count_is_named(path, key, wanted, has):
    message = refused_load(path, with_entry(key, {'rows': 3, 'cols': 3, 'data': [1.0] * has}))
    assert message == 'calibration {} has no usable entry {} (wants {} numbers, has {})'.format(
        path, key, wanted, has)


@pytest.mark.parametrize('broken, words', BROKEN)
def test_calibration_that_cannot_rectify_is_refused(path, broken, words):
    calibration_file.save(path, dataclasses.replace(KNOWN, **broken))
    with open(path) as file:
        message = refused_load(path, file.read())
    assert re.search('^calibration .* has no usable entry ' + words, message), message


@pytest.mark.parametrize('value', [True, None, [500], 'a'])
def test_value_that_is_not_a_number_is_named(path, value):
    data = [value, 0, 320, 0, 500, 240, 0, 0, 1]
    message = refused_load(path, with_entry('camera_matrix', {'rows': 3, 'cols': 3, 'data': data}))
    assert message.endswith('entry camera_matrix (wants numbers, has {!r})'.format(value))


@pytest.mark.parametrize('key, shape, wanted', [
    ('camera_matrix', (4, 7), 'rows: 3, cols: 3, has 4, 7'),
    ('camera_matrix', (9, 1), 'rows: 3, cols: 3, has 9, 1'),
    ('camera_matrix', ('x', None), "rows: 3, cols: 3, has 'x', None"),
    ('projection_matrix', (4, 3), 'rows: 3, cols: 4, has 4, 3'),
    ('distortion_coefficients', (1, 7), 'rows x cols numbers, has 5 for 1 x 7')])
def test_shape_that_does_not_match_the_data_is_named(path, key, shape, wanted):
    data = yaml.safe_load(FOREIGN)[key]['data']
    message = refused_load(path, with_entry(
        key, {'rows': shape[0], 'cols': shape[1], 'data': data}))
    assert message.endswith('entry {} (wants {})'.format(key, wanted))


def test_column_vector_of_coefficients_and_missing_shapes_are_accepted(path):
    content = yaml.safe_load(FOREIGN)
    content['distortion_coefficients'].update(rows=5, cols=1)
    del content['camera_matrix']['rows'], content['camera_matrix']['cols']
    with open(path, 'w') as file:
        yaml.safe_dump(content, file)
    assert len(calibration_file.load(path).distortion) == 5


def test_missing_or_empty_camera_name_is_an_empty_one(path):
    for name in ('camera_name: narrow\n', 'camera_name:\n'):
        with open(path, 'w') as file:
            file.write(FOREIGN.replace('camera_name: narrow\n', '' if 'narrow' in name else name))
        assert calibration_file.load(path).camera_name == ''


def bomb(key):
    """Return a few lines of YAML that expand to a list of millions, as the entry `key`."""
    lines = ['a0: &a0 [{}]'.format(', '.join(['xxxxxxxx'] * 9))]
    lines += ['a{}: &a{} [{}]'.format(n, n, ', '.join(['*a{}'.format(n - 1)] * 9))
              for n in range(1, 8)]
    return '\n'.join(lines) + '\n' + '{}: *a7\n'.format(key)


LONG = {
    **{'bomb in ' + key: bomb(key) + ''.join(line for line in FOREIGN.splitlines(True)
                                             if not line.startswith(key))
       for key in ('image_width', 'camera_name')},
    'long model': FOREIGN.replace('plumb_bob', 'p' * 9999),
    'long number': FOREIGN.replace('[500', '[' + 'x' * 9999),
    'deep lists': '[' * 500,
    'deep maps': 'a: ' + '{' * 500,
    'long directive': '%' + 'x' * 5000,
    'long anchor': '&' + 'y' * 9999 + ' a: [',
}


@pytest.mark.parametrize('name', LONG)
def test_error_line_is_short_for_any_content(path, name):
    assert len(refused_load(path, LONG[name])) - len(path) < 400


def test_file_that_is_too_large_is_refused(path):
    assert refused_load(path, FOREIGN + '#' * (1 << 20)) == (
        'cannot read calibration {}: larger than 1048576 bytes'.format(path))


def test_pipe_is_refused_without_waiting(path):
    os.mkfifo(path)
    with pytest.raises(CalibrationError, match='^cannot read calibration .*: not a regular file$'):
        calibration_file.load(path)


def test_file_of_the_largest_size_is_read(path):
    with open(path, 'w') as file:
        file.write('# ' + 'a' * ((1 << 20) - 2))
    with pytest.raises(CalibrationError, match='has no camera_matrix'):
        calibration_file.load(path)
    with open(path, 'a') as file:
        file.write('a')
    with pytest.raises(CalibrationError, match='larger than 1048576 bytes$'):
        calibration_file.load(path)
