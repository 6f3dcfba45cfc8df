"""Calibrations: which are usable, other image sizes, and their files."""
import dataclasses
import os
import stat

import pytest
import yaml

from img_recog.camera import calibration
from img_recog.camera.calibration import CalibrationError
from img_recog_helpers import expected
from img_recog_helpers.calibrations import KNOWN, OTHER
from img_recog_helpers.refusals import refusal

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


def write(path, content):
    """Write text, or FOREIGN with some entries replaced."""
    if isinstance(content, dict):
        content = yaml.safe_dump({**yaml.safe_load(FOREIGN), **content})
    with open(path, 'wb') as file:
        file.write(content if isinstance(content, bytes) else content.encode())


def refused_load(path, content):
    write(path, content)
    line = refusal(calibration.load, path)
    assert path in line
    return line


def test_calibration_that_cannot_rectify_is_refused(path):
    def line(text):
        given = dataclasses.replace(KNOWN, **{
            name: tuple(value) if isinstance(value, list) else value
            for name, value in yaml.safe_load(text).items()})
        problem = refusal(calibration.check, given)
        calibration.save(path, given)
        assert refusal(calibration.load, path) == problem.replace(
            'the calibration', 'calibration ' + path)
        return problem
    expected.check_cases('refused/calibration_values.txt', line)


@pytest.mark.parametrize('fields', [
    {'width': 1, 'height': 1},
    {'camera_matrix': (0.5, 0.0, 320.0, 0.0, 0.5, 240.0, 0.0, 0.0, 1.0)},
    # the numbers of coefficients that OpenCV accepts
    *({'distortion_model': model, 'distortion': (0.1,) * count} for model, count in (
        ('plumb_bob', 5), ('plumb_bob', 4), ('rational_polynomial', 8),
        ('rational_polynomial', 12), ('rational_polynomial', 14), ('equidistant', 4),
        ('plumb_bob', 0))),
    # names that YAML could read as another type
    *({'camera_name': name} for name in ('', 'yes', '12', 'a: b', 'カメラ'))])
def test_calibration_that_is_usable_is_saved_and_loaded_exactly(path, fields):
    given = dataclasses.replace(KNOWN, **fields)
    calibration.check(given)
    calibration.save(path, given)
    assert calibration.load(path) == given


def test_scaled_to_half_the_size_and_to_its_own():
    small = calibration.scaled(KNOWN, 320, 240)
    assert small == dataclasses.replace(
        KNOWN, width=320, height=240,
        camera_matrix=(250.25, 0.0, 160.0, 0.0, 250.625, 120.0, 0.0, 0.0, 1.0),
        projection=(250.25, 0.0, 160.0, -5e-18, 0.0, 250.625, 120.0, 0.0, 0.0, 0.0, 1.0, 0.0))
    assert calibration.scaled(KNOWN, 640, 480) is KNOWN


@pytest.mark.parametrize('own, size, is_allowed', [     # the ratio may differ by one percent
    ((1920, 1080), (854, 480), True), ((640, 480), (646, 480), True),
    ((640, 480), (640, 484), True),
    *(((640, 480), size, False) for size in ((640, 360), (480, 640), (640, 470), (1, 480),
                                             (647, 480), (640, 485), (0, 480), (640, 0))),
    *((own, (320, 240), False) for own in ((0, 0), (0, 480), (640, 0), (-640, -480),
                                           (-640, 480), (0, 240), (320, 0))),
    ((640, 0), (640, 240), False)])
def test_another_aspect_ratio_is_refused(own, size, is_allowed):
    given = dataclasses.replace(KNOWN, width=own[0], height=own[1])
    if is_allowed:
        scaled = calibration.scaled(given, *size)
        assert (scaled.width, scaled.height) == size
        assert scaled.camera_matrix[0] == pytest.approx(500.5 * size[0] / own[0])
    else:
        assert refusal(calibration.scaled, given, *size) == (
            'the calibration is for {}x{}, the images are {}x{}, another aspect ratio'.format(
                *own, *size))


def test_file_of_another_program_is_read(path):
    write(path, FOREIGN)
    loaded = calibration.load(path)
    assert (loaded.camera_name, loaded.width, loaded.height) == ('narrow', 640, 480)
    assert loaded.distortion == (1e-05, -2e-3, 0.0, 0.0, 0.0)
    assert loaded.camera_matrix == (500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0)
    assert type(loaded.camera_matrix[0]) is float
    write(path, {'camera_name': None, 'camera_matrix': {'data': [1] * 9},
                 'distortion_coefficients': {'rows': 5, 'cols': 1, 'data': [0] * 5}})
    loaded = calibration.load(path)
    assert loaded.camera_name == '' and loaded.distortion == (0,) * 5
    write(path, FOREIGN.replace('camera_name: narrow\n', ''))
    assert calibration.load(path).camera_name == ''


WITHOUT_MODEL = FOREIGN.replace('distortion_model: plumb_bob\n', '')
COEFFICIENTS = '{rows: 1, cols: 5, data: [1e-05, -2E-3, 0, 0, 0]}'


@pytest.mark.parametrize('content, model, count, assumed', [
    (FOREIGN, 'plumb_bob', 5, None),
    ('%YAML:1.0\n---\n' + FOREIGN.replace('{rows', '!!opencv-matrix {rows').replace(
        'matrix:\n', 'matrix: !!opencv-matrix\n').replace(', data', ', dt: d, data'),
     'plumb_bob', 5, None),
    (WITHOUT_MODEL, 'plumb_bob', 5, 'no distortion_model, assuming plumb_bob'),
    (WITHOUT_MODEL.replace(COEFFICIENTS, '{rows: 8, cols: 1, data: [0, 0, 0, 0, 0, 0, 0, 0]}'),
     'rational_polynomial', 8, 'no distortion_model, assuming rational_polynomial'),
    *((FOREIGN.replace(COEFFICIENTS, '{{rows: {}, cols: {}, data: []}}'.format(*shape)),
       'plumb_bob', 0, 'no distortion_coefficients, assuming an image without distortion')
      for shape in ((0, 0), (1, 0), (0, 1))),
    (WITHOUT_MODEL.replace(COEFFICIENTS, '{data: []}'), 'plumb_bob', 0,
     'no distortion_model, assuming plumb_bob, and no distortion_coefficients, assuming an image '
     'without distortion')])
def test_what_the_file_does_not_state_is_assumed_with_one_warning(
        path, content, model, count, assumed):
    write(path, content)
    lines = []
    found = calibration.load(path, lines.append)
    assert (found.distortion_model, len(found.distortion)) == (model, count)
    assert found.camera_matrix == (500, 0, 320, 0, 501, 240, 0, 0, 1)
    assert lines == ([] if assumed is None else
                     ['calibration {} has {}'.format(path, assumed)])


def test_missing_file_is_a_separate_error(path):
    with pytest.raises(FileNotFoundError):
        calibration.load(path)


LARGEST = '# ' + 'a' * ((1 << 20) - 2)


@pytest.mark.parametrize('content, problem', [
    *((content, 'cannot read calibration {}: ') for content in (
        'a: [1, 2', 'a: b: c', '\tx: 1', b'\x00\x01\x02', b'\x89PNG\r\n\x1a\n\xff\xfe',
        b'\xff' * 99, FOREIGN.replace('narrow', '2020-13-45'))),
    (LARGEST + 'a', 'cannot read calibration {}: larger than 1048576 bytes'),
    *((content, 'has no camera_matrix and other entries; write one with ') for content in (
        '', 'just words', '[1, 2]', '5', LARGEST)),
    *(({'camera_matrix': value}, ' has no usable entry data (wants the numbers of camera_matrix, ')
      for value in ({'rows': 3}, {'data': '123456789'}))], ids=lambda value: repr(value)[:20])
def test_file_that_is_no_calibration(path, content, problem):
    assert problem.format(path) in refused_load(path, content)


def test_entry_that_is_wrong_is_named(path):
    expected.check_cases('refused/calibrations.txt', lambda text: refused_load(
        path, yaml.safe_load(text)).replace(path, 'FILE'))


def bomb(key):
    """Return a few lines of YAML that expand to a list of millions, as the entry `key`."""
    lines = ['a0: &a0 [{}]'.format(', '.join(['xxxxxxxx'] * 9))]
    lines += ['a{}: &a{} [{}]'.format(n, n, ', '.join(['*a{}'.format(n - 1)] * 9))
              for n in range(1, 8)]
    return '\n'.join(lines) + '\n' + '{}: *a7\n'.format(key) + ''.join(
        line for line in FOREIGN.splitlines(True) if not line.startswith(key))


@pytest.mark.parametrize('content', [
    bomb('image_width'), bomb('camera_name'), FOREIGN.replace('plumb_bob', 'p' * 9999),
    FOREIGN.replace('[500', '[' + 'x' * 9999), '[' * 500, 'a: ' + '{' * 500, '%' + 'x' * 5000,
    '&' + 'y' * 9999 + ' a: ['], ids=lambda content: content[:20])
def test_error_line_is_short_for_any_content(path, content):
    assert len(refused_load(path, content)) - len(path) < 400


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


@pytest.mark.parametrize('link', ['', 'kept/real.yaml'])
def test_saving_makes_the_folder_replaces_the_old_file_and_follows_a_symlink(tmp_path, link):
    path = tmp_path / 'ros' / 'camera_info' / 'head_camera.yaml'
    if link:
        path.parent.mkdir(parents=True)
        path.symlink_to(link)
    calibration.save(str(path), KNOWN)
    calibration.save(str(path), OTHER)
    assert calibration.load(str(path)) == OTHER and path.is_symlink() == bool(link)
    target = path.resolve()
    assert not target.is_symlink() and os.listdir(str(target.parent)) == [target.name]


@pytest.mark.parametrize('call', ['os.replace', 'os.fchmod', 'yaml.safe_dump'])
def test_failure_leaves_the_old_file_and_nothing_else(path, monkeypatch, call):
    def fail(*_, **__):
        raise OSError(28, 'No space left on device')
    calibration.save(path, KNOWN)
    with monkeypatch.context() as patched:
        patched.setattr('img_recog.camera.calibration.' + call, fail)
        assert refusal(calibration.save, path, OTHER) == (
            'cannot write calibration {}: No space left on device'.format(path))
    assert calibration.load(path) == KNOWN
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


def test_saving_below_a_file_is_refused(path):
    calibration.save(path, KNOWN)
    assert '/head_camera.yaml/deeper.yaml: ' in refusal(
        calibration.save, path + '/deeper.yaml', OTHER)
    assert calibration.load(path) == KNOWN


@pytest.mark.parametrize('make', [os.mkfifo, os.mkdir, lambda path: os.symlink('/dev/null', path)])
def test_special_file_is_neither_read_nor_replaced(path, make, monkeypatch):
    make(path)
    # if the check is gone, the device node of this machine must not be replaced
    monkeypatch.setattr('img_recog.camera.calibration.os.replace', pytest.fail)
    for words, call in (
            ('^cannot write calibration .*: it is a (folder|device or pipe)$',
             lambda: calibration.save(path, KNOWN)),
            ('^cannot read calibration .*: (.* is a pipe or device, not a file|Is a directory)$',
             lambda: calibration.load(path))):
        with pytest.raises(CalibrationError, match=words):
            call()
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']
