"""Each thing that can be wrong with a machine is caused, and found."""
import os
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from collections import namedtuple

import pytest

from img_recog.doctor import machine
from img_recog_helpers.pages import read

Usage = namedtuple('Usage', 'total used free')


@pytest.fixture(autouse=True)
def local(monkeypatch):
    """The environment of ./run, in English."""
    for name in ('LC_ALL', 'LC_MESSAGES', 'LANG', 'ROS_IP', 'ROS_MASTER_URI'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('ROS_HOSTNAME', 'localhost')


def problem(check, *arguments):
    found, = check(*arguments)
    assert found.advice
    return found.problem


@pytest.mark.parametrize('check', [each for each in machine.CHECKS
                                   if each not in (machine.check_camera, machine.check_python)])
def test_nothing_is_wrong_here(check):
    assert list(check()) == []


def test_a_python_without_rospy_that_is_first_on_path(monkeypatch, tmp_path):
    (tmp_path / 'python3').write_text('#!/bin/sh\nexec /usr/bin/python3 -I -S "$@"\n')
    (tmp_path / 'python3').chmod(0o755)
    monkeypatch.setenv('PATH', str(tmp_path), prepend=os.pathsep)
    assert problem(machine.check_python) == (
        "{}/python3 is first on PATH and has no rospy: ModuleNotFoundError: No module named "
        "'rospy'".format(tmp_path))
    monkeypatch.setenv('PATH', '/usr/bin')
    assert list(machine.check_python()) == []


def test_libraries_and_messages_that_are_missing(monkeypatch):
    monkeypatch.setattr('sys.path', [])
    monkeypatch.setattr('sys.meta_path', [])
    monkeypatch.setattr('sys.modules', {})
    assert problem(machine.check_libraries).endswith(' has no ' + ', '.join(machine.LIBRARIES))
    assert problem(machine.check_message_packages) == (
        'message packages are missing: ' + ', '.join(machine.MESSAGE_PACKAGES))


def test_one_message_package_that_is_missing():
    found, = machine.missing_packages({'no_such_msgs', 'sensor_msgs'})
    assert found.problem == 'message packages are missing: no_such_msgs'
    assert 'no-such-msgs"' in found.advice


def test_the_message_packages_are_those_of_the_package():
    needed = {each.text for each in ElementTree.fromstring(read('package.xml'))
              if each.tag == 'exec_depend' and each.text.endswith(('_msgs', '_srvs'))}
    assert set(machine.MESSAGE_PACKAGES) == needed


def test_a_numpy_that_cv_bridge_is_not_built_with(monkeypatch, tmp_path):
    (tmp_path / 'numpy').mkdir()
    (tmp_path / 'numpy' / '__init__.py').write_text('__version__ = "2.9"\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    assert problem(machine.check_cv_bridge).startswith(
        'cv_bridge cannot be loaded beside numpy 2.9: ')


def test_no_camera_is_a_note(tmp_path):
    found, = machine.check_camera(str(tmp_path / 'video*'))
    assert found.is_note and found.problem == 'there is no camera: no {}/video*'.format(tmp_path)


def test_a_camera_that_may_not_be_opened(tmp_path, monkeypatch):
    (tmp_path / 'video0').touch()
    assert list(machine.check_camera(str(tmp_path / 'video*'))) == []
    monkeypatch.setattr(os, 'access', lambda *_: False)     # root may open anything
    assert problem(machine.check_camera, str(tmp_path / 'video*')) == (
        'no permission to open {}/video0'.format(tmp_path))


def test_no_opengl(monkeypatch):
    monkeypatch.setenv('__EGL_VENDOR_LIBRARY_FILENAMES', '/no_such_file')
    assert problem(machine.check_opengl).startswith('images of the simulator cannot be drawn: ')


def test_a_full_disk_and_a_folder_that_cannot_be_written(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    monkeypatch.setattr(tempfile, 'gettempdir', lambda: str(tmp_path))
    assert list(machine.check_disk()) == []
    with monkeypatch.context() as context:
        context.setattr(shutil, 'disk_usage', lambda _: Usage(10 ** 9, 10 ** 9, 5 * 10 ** 6))
        assert problem(machine.check_disk) == (
            'the disk of {} is full: 5 MB are free'.format(tmp_path))
    monkeypatch.setenv('ROS_HOME', '/proc/1/no_such_folder')
    assert problem(machine.check_disk).startswith('cannot write in /proc/1: ')


@pytest.mark.parametrize('environment, words', [
    ({'ROS_MASTER_URI': 'localhost:11311'}, 'ROS_MASTER_URI is localhost:11311, expected'),
    ({'ROS_MASTER_URI': 'http://no-such-host.invalid:11311'},
     'ROS_MASTER_URI names no-such-host.invalid, which'),
    ({'ROS_HOSTNAME': '', 'ROS_IP': '192.0.2.7'},
     'ROS_IP=192.0.2.7 is not an address of this computer'),
    ({'ROS_HOSTNAME': 'no-such-host.invalid'},
     'ROS_HOSTNAME=no-such-host.invalid is not an address of this computer'),
    ({'ROS_MASTER_URI': 'http://192.0.2.1:11311'},
     'ROS_HOSTNAME=localhost can be reached on this computer alone, and the master is on '
     '192.0.2.1')])
def test_addresses_that_are_wrong(monkeypatch, environment, words):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert problem(machine.check_addresses).startswith(words)
