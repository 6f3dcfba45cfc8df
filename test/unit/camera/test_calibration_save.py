"""Saving calibrations: the format, atomic writes, and paths that are never replaced."""
import os
import stat

import pytest
import yaml

from img_recog.camera import calibration_file
from img_recog.camera.calibration import CalibrationError
from img_recog_testing.calibrations import KNOWN, OTHER


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / 'head_camera.yaml')


def test_file_has_the_layout_of_camera_calibration_parsers(path):
    calibration_file.save(path, KNOWN)
    with open(path) as file:
        content = yaml.safe_load(file)
    assert list(content) == [
        'image_width', 'image_height', 'camera_name', 'distortion_model', 'camera_matrix',
        'distortion_coefficients', 'rectification_matrix', 'projection_matrix']
    assert content['projection_matrix'] == {'rows': 3, 'cols': 4, 'data': list(KNOWN.projection)}
    assert content['distortion_coefficients']['cols'] == 5
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o644


def test_saving_makes_the_folder_and_replaces_the_old_file(tmp_path):
    path = str(tmp_path / 'ros' / 'camera_info' / 'head_camera.yaml')
    calibration_file.save(path, KNOWN)
    calibration_file.save(path, OTHER)
    assert calibration_file.load(path) == OTHER
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


@pytest.mark.parametrize('call', ['os.replace', 'os.fchmod', 'yaml.safe_dump'])
def test_failure_leaves_the_old_file_and_nothing_else(path, monkeypatch, call):
    def fail(*_, **__):
        raise OSError(28, 'No space left on device')
    calibration_file.save(path, KNOWN)
    with monkeypatch.context() as patched:
        patched.setattr('img_recog.camera.calibration_file.' + call, fail)
        with pytest.raises(CalibrationError) as refused:
            calibration_file.save(path, OTHER)
    assert str(refused.value) == (
        'cannot write calibration {}: No space left on device'.format(path))
    assert calibration_file.load(path) == KNOWN
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


def test_saving_over_a_folder_is_refused_and_leaves_nothing(tmp_path):
    os.mkdir(str(tmp_path / 'folder'))
    with pytest.raises(CalibrationError, match='^cannot write calibration .*/folder: '):
        calibration_file.save(str(tmp_path / 'folder'), KNOWN)
    assert os.listdir(str(tmp_path)) == ['folder'] and not os.listdir(str(tmp_path / 'folder'))


def test_saving_below_a_file_is_refused(path):
    calibration_file.save(path, KNOWN)
    with pytest.raises(CalibrationError, match='/head_camera.yaml/deeper.yaml: '):
        calibration_file.save(path + '/deeper.yaml', OTHER)
    assert calibration_file.load(path) == KNOWN


@pytest.mark.skipif(os.geteuid() == 0, reason='root may write into every folder')
def test_unwritable_folder_leaves_the_old_file(path):
    calibration_file.save(path, KNOWN)
    os.chmod(os.path.dirname(path), 0o555)
    with pytest.raises(CalibrationError, match='Permission denied$'):
        calibration_file.save(path, OTHER)
    os.chmod(os.path.dirname(path), 0o755)
    assert calibration_file.load(path) == KNOWN


def make_special(file_type, path):
    if file_type == 'pipe':
        os.mkfifo(path)
    elif file_type == 'device':
        os.symlink('/dev/null', path)
    else:
        os.mkdir(path)


@pytest.mark.parametrize('file_type', ['pipe', 'device', 'folder'])
def test_special_file_is_not_replaced(path, file_type, monkeypatch):
    make_special(file_type, path)
    # if the check is gone, the device node of this machine must not be replaced
    monkeypatch.setattr('img_recog.camera.calibration_file.os.replace', pytest.fail)
    with pytest.raises(CalibrationError,
                       match='^cannot write calibration .*: not a regular file$'):
        calibration_file.save(path, KNOWN)
    assert os.listdir(os.path.dirname(path)) == ['head_camera.yaml']


@pytest.mark.parametrize('exists', [True, False])
def test_symlink_stays_and_its_target_is_written(tmp_path, path, exists):
    target = str(tmp_path / 'kept' / 'real.yaml')
    os.symlink(os.path.join('kept', 'real.yaml'), path)
    if exists:
        calibration_file.save(target, OTHER)
    calibration_file.save(path, KNOWN)
    assert os.path.islink(path) and not os.path.islink(target)
    assert calibration_file.load(target) == KNOWN
    assert os.listdir(os.path.dirname(target)) == ['real.yaml']
