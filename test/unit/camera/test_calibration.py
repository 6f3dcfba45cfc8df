"""Calibration files: round trip, whole or not at all, and refusals that name file and entry."""
import dataclasses
import os
import re
import stat

import pytest
import yaml

from img_recog.camera import calibration
from img_recog.camera.calibration import Calibration, CalibrationError
from img_recog.errors import UserError

KNOWN = Calibration(
    camera_name='head_camera', width=640, height=480, distortion_model='plumb_bob',
    distortion=(0.1, -0.25, 1e-05, 0.0, 1 / 3),
    camera_matrix=(500.5, 0.0, 320.0, 0.0, 501.25, 240.0, 0.0, 0.0, 1.0),
    rectification=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    projection=(500.5, 0.0, 320.0, -1e-17, 0.0, 501.25, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0))
OTHER = Calibration('other', 320, 240, 'rational_polynomial', (0.5,) * 8, (2.0,) * 9, (3.0,) * 9,
                    (4.0,) * 12)

# as camera_calibration_parsers writes it, by yaml-cpp: numbers such as 1e-05 have no point
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
    """The error line that loading `content` ends with."""
    with open(path, 'wb') as file:
        file.write(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(CalibrationError) as refused:
        calibration.load(path)
    assert isinstance(refused.value, UserError)
    assert path in str(refused.value) and '\n' not in str(refused.value)
    return str(refused.value)


def with_entry(key, value):
    """FOREIGN with one entry replaced."""
    return yaml.safe_dump(dict(yaml.safe_load(FOREIGN), **{key: value}))


@pytest.mark.parametrize('known', [KNOWN, OTHER])
def test_round_trip_is_exact(path, known):
    calibration.save(path, known)
    assert calibration.load(path) == known


@pytest.mark.parametrize('name', ['', 'yes', '12', 'a: b', 'カメラ'])
def test_round_trip_of_names_that_yaml_could_take_for_something_else(path, name):
    named = Calibration(name, *[getattr(KNOWN, field) for field in (
        'width', 'height', 'distortion_model', 'distortion', 'camera_matrix', 'rectification',
        'projection')])
    calibration.save(path, named)
    assert calibration.load(path) == named


def test_file_has_the_layout_of_camera_calibration_parsers(path):
    calibration.save(path, KNOWN)
    with open(path) as file:
        content = yaml.safe_load(file)
    assert list(content) == [
        'image_width', 'image_height', 'camera_name', 'distortion_model', 'camera_matrix',
        'distortion_coefficients', 'rectification_matrix', 'projection_matrix']
    assert content['projection_matrix'] == {'rows': 3, 'cols': 4, 'data': list(KNOWN.projection)}
    assert content['distortion_coefficients']['cols'] == 5
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o644


def test_file_of_another_program_is_read(path):
    with open(path, 'w') as file:
        file.write(FOREIGN)
    loaded = calibration.load(path)
    assert (loaded.camera_name, loaded.width, loaded.height) == ('narrow', 640, 480)
    assert loaded.distortion == (1e-05, -2e-3, 0.0, 0.0, 0.0)
    assert loaded.camera_matrix == (500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0)
    assert type(loaded.camera_matrix[0]) is float


def test_missing_file_is_told_apart(path):
    with pytest.raises(FileNotFoundError):
        calibration.load(path)


def test_saving_makes_the_folder_and_replaces_the_old_file(tmp_path):
    path = str(tmp_path / 'ros' / 'camera_info' / 'head_camera.yaml')
    calibration.save(path, KNOWN)
    calibration.save(path, OTHER)
    assert calibration.load(path) == OTHER
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


@pytest.mark.parametrize('call', ['os.replace', 'os.chmod', 'yaml.safe_dump'])
def test_failure_leaves_the_old_file_and_nothing_else(path, monkeypatch, call):
    def fail(*_, **__):
        raise OSError(28, 'No space left on device')
    calibration.save(path, KNOWN)
    with monkeypatch.context() as patched:
        patched.setattr('img_recog.camera.calibration.' + call, fail)
        with pytest.raises(CalibrationError) as refused:
            calibration.save(path, OTHER)
    assert str(refused.value) == (
        'cannot write calibration {}: No space left on device'.format(path))
    assert calibration.load(path) == KNOWN
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


def test_saving_over_a_folder_is_refused_and_leaves_nothing(tmp_path):
    os.mkdir(str(tmp_path / 'folder'))
    with pytest.raises(CalibrationError, match='^cannot write calibration .*/folder: '):
        calibration.save(str(tmp_path / 'folder'), KNOWN)
    assert os.listdir(str(tmp_path)) == ['folder'] and not os.listdir(str(tmp_path / 'folder'))


def test_saving_below_a_file_is_refused(path):
    calibration.save(path, KNOWN)
    with pytest.raises(CalibrationError, match='/head_camera.yaml/deeper.yaml: '):
        calibration.save(path + '/deeper.yaml', OTHER)
    assert calibration.load(path) == KNOWN


@pytest.mark.skipif(os.geteuid() == 0, reason='root may write into every folder')
def test_unwritable_folder_leaves_the_old_file(path):
    calibration.save(path, KNOWN)
    os.chmod(os.path.dirname(path), 0o555)
    with pytest.raises(CalibrationError, match='Permission denied$'):
        calibration.save(path, OTHER)
    os.chmod(os.path.dirname(path), 0o755)
    assert calibration.load(path) == KNOWN


@pytest.mark.parametrize('content', [
    'a: [1, 2', 'a: b: c', '\tx: 1', b'\x00\x01\x02', b'\x89PNG\r\n\x1a\n\xff\xfe', b'\xff' * 99,
    FOREIGN.replace('narrow', '2020-13-45')])
def test_file_that_is_no_yaml(path, content):
    assert refused_load(path, content).startswith('cannot read calibration ' + path + ': ')


@pytest.mark.parametrize('content', ['', 'just words', '[1, 2]', '5'])
def test_yaml_without_entries(path, content):
    assert 'holds no camera_matrix and other entries' in refused_load(path, content)


def test_folder_in_place_of_a_file(tmp_path):
    with pytest.raises(CalibrationError) as refused:
        calibration.load(str(tmp_path))
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


# what is wrong with a calibration, by field, and what the line says of it
BROKEN = [
    ({'width': 0}, r'image_width \(wants a whole number above 0, has 0\)'),
    ({'height': -480}, r'image_height \(wants a whole number above 0, has -480\)'),
    ({'camera_matrix': (float('nan'),) + KNOWN.camera_matrix[1:]},
     r'camera_matrix \(wants finite numbers, has nan\)'),
    ({'projection': KNOWN.projection[:-1] + (float('inf'),)},
     r'projection_matrix \(wants finite numbers, has inf\)'),
    ({'camera_matrix': (0.0,) * 9},
     r'camera_matrix \(wants a focal length fx above 0, has 0\)'),
    ({'distortion_model': 'plum_bob'},
     r"distortion_model \(wants one of .*plumb_bob, rational_polynomial, has 'plum_bob'\)"),
    ({'distortion_model': ''}, r"distortion_model \(wants one of .*, has ''\)"),
    ({'distortion': ()},
     r'distortion_coefficients \(wants 5 or 4 numbers for plumb_bob, has 0\)'),
    ({'distortion': (0.1,) * 3},
     r'distortion_coefficients \(wants 5 or 4 numbers for plumb_bob, has 3\)'),
    ({'distortion_model': 'equidistant'},
     r'distortion_coefficients \(wants 4 numbers for equidistant, has 5\)'),
]


@pytest.mark.parametrize('broken, words', BROKEN)
def test_calibration_that_rectifies_nothing_is_refused(path, broken, words):
    given = dataclasses.replace(KNOWN, **broken)
    with pytest.raises(CalibrationError, match='^the calibration has no usable entry ' + words):
        calibration.check(given)
    calibration.save(path, given)
    with open(path) as file:
        message = refused_load(path, file.read())
    assert re.search('^calibration .* has no usable entry ' + words, message), message


@pytest.mark.parametrize('model, count', [
    ('plumb_bob', 5), ('plumb_bob', 4), ('rational_polynomial', 8), ('rational_polynomial', 12),
    ('rational_polynomial', 14), ('equidistant', 4)])
def test_models_have_the_coefficients_that_opencv_knows(model, count):
    calibration.check(dataclasses.replace(
        KNOWN, distortion_model=model, distortion=(0.1,) * count))


@pytest.mark.parametrize('value', [True, None, [500], 'a'])
def test_what_is_no_number_is_named(path, value):
    data = [value, 0, 320, 0, 500, 240, 0, 0, 1]
    message = refused_load(path, with_entry('camera_matrix', {'rows': 3, 'cols': 3, 'data': data}))
    assert message.endswith('entry camera_matrix (wants numbers, has {!r})'.format(value))


@pytest.mark.parametrize('key, shape, wanted', [
    ('camera_matrix', (4, 7), 'rows: 3, cols: 3, has 4, 7'),
    ('camera_matrix', (9, 1), 'rows: 3, cols: 3, has 9, 1'),
    ('camera_matrix', ('x', None), "rows: 3, cols: 3, has 'x', None"),
    ('projection_matrix', (4, 3), 'rows: 3, cols: 4, has 4, 3'),
    ('distortion_coefficients', (1, 7), 'rows x cols numbers, has 5 for 1 x 7')])
def test_shape_that_does_not_fit_the_numbers_is_named(path, key, shape, wanted):
    data = yaml.safe_load(FOREIGN)[key]['data']
    message = refused_load(path, with_entry(
        key, {'rows': shape[0], 'cols': shape[1], 'data': data}))
    assert message.endswith('entry {} (wants {})'.format(key, wanted))


def test_upright_vector_of_coefficients_and_missing_shapes_are_taken(path):
    content = yaml.safe_load(FOREIGN)
    content['distortion_coefficients'].update(rows=5, cols=1)
    del content['camera_matrix']['rows'], content['camera_matrix']['cols']
    with open(path, 'w') as file:
        yaml.safe_dump(content, file)
    assert len(calibration.load(path).distortion) == 5


def test_missing_or_empty_camera_name_is_an_empty_one(path):
    for name in ('camera_name: narrow\n', 'camera_name:\n'):
        with open(path, 'w') as file:
            file.write(FOREIGN.replace('camera_name: narrow\n', '' if 'narrow' in name else name))
        assert calibration.load(path).camera_name == ''


def bomb(key):
    """A few lines that stand for a list of millions, as the entry `key`."""
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
    'deep lists': '[' * 2000,
    'deep maps': 'a: ' + '{' * 2000,
    'long directive': '%' + 'x' * 5000,
    'long anchor': '&' + 'y' * 9999 + ' a: [',
}


@pytest.mark.parametrize('name', LONG)
def test_line_of_an_error_is_short_whatever_the_file_holds(path, name):
    assert len(refused_load(path, LONG[name])) - len(path) < 400


def test_file_that_is_too_long_for_a_calibration_is_not_read(path):
    assert refused_load(path, FOREIGN + '#' * (1 << 20)) == (
        'cannot read calibration {}: larger than 1048576 bytes'.format(path))


def test_pipe_is_refused_and_not_waited_for(path):
    os.mkfifo(path)
    with pytest.raises(CalibrationError, match='^cannot read calibration .*: not a regular file$'):
        calibration.load(path)


def special(kind, path):
    if kind == 'pipe':
        os.mkfifo(path)
    elif kind == 'device':
        os.symlink('/dev/null', path)
    else:
        os.mkdir(path)


@pytest.mark.parametrize('kind', ['pipe', 'device', 'folder'])
def test_what_is_no_file_is_not_written_over(path, kind, monkeypatch):
    special(kind, path)
    # should the mend be gone: the device node of this machine is not to be replaced
    monkeypatch.setattr('img_recog.camera.calibration.os.replace', pytest.fail)
    with pytest.raises(CalibrationError,
                       match='^cannot write calibration .*: not a regular file$'):
        calibration.save(path, KNOWN)
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


@pytest.mark.parametrize('exists', [True, False])
def test_link_stays_and_the_file_it_stands_for_is_written(tmp_path, path, exists):
    target = str(tmp_path / 'kept' / 'real.yaml')
    os.symlink(os.path.join('kept', 'real.yaml'), path)
    if exists:
        calibration.save(target, OTHER)
    calibration.save(path, KNOWN)
    assert os.path.islink(path) and not os.path.islink(target)
    assert calibration.load(target) == KNOWN
    assert os.listdir(os.path.dirname(target)) == ['real.yaml']


def test_scaled_to_half_the_size():
    small = calibration.scaled(KNOWN, 320, 240)
    assert (small.width, small.height) == (320, 240)
    assert small.camera_matrix == (250.25, 0.0, 160.0, 0.0, 250.625, 120.0, 0.0, 0.0, 1.0)
    assert small.projection == (250.25, 0.0, 160.0, -5e-18, 0.0, 250.625, 120.0, 0.0, 0.0, 0.0,
                                1.0, 0.0)
    assert (small.distortion, small.rectification, small.camera_name) == (
        KNOWN.distortion, KNOWN.rectification, KNOWN.camera_name)


def test_scaled_to_its_own_size_is_itself():
    assert calibration.scaled(KNOWN, 640, 480) is KNOWN


def test_scaled_to_a_size_that_a_camera_rounds():
    wide = Calibration('wide', 1920, 1080, 'plumb_bob', (0.0,) * 5, KNOWN.camera_matrix,
                       KNOWN.rectification, KNOWN.projection)
    assert calibration.scaled(wide, 854, 480).width == 854


@pytest.mark.parametrize('size', [(640, 360), (480, 640), (640, 470), (1, 480)])
def test_another_aspect_ratio_is_refused(size):
    with pytest.raises(CalibrationError, match='^the calibration is for 640x480, the images are '
                                               '{}x{}, another shape$'.format(*size)):
        calibration.scaled(KNOWN, *size)


def test_calibration_without_a_size_is_refused():
    empty = Calibration('x', 0, 0, 'plumb_bob', (), KNOWN.camera_matrix, KNOWN.rectification,
                        KNOWN.projection)
    with pytest.raises(CalibrationError):
        calibration.scaled(empty, 640, 480)
