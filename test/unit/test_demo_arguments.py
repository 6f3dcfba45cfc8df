"""What ./run demo refuses before anything starts, in one line, and its help."""
import errno
import os
import shlex
from unittest import mock

import pytest

from img_recog_helpers import expected
from img_recog_helpers.pages import LAUNCH_FOLDER, launch_arguments, tool
from img_recog_helpers.refusals import refusal

SWITCHES = ('gui', 'image_view', 'paused', 'recognition', 'simulator', 'teleop', 'use_sim_time',
            'allow_partial_world', 'vision')


@pytest.fixture
def checked(capsys, monkeypatch):
    """A function that checks the arguments of the demo; it returns exit code and output."""
    monkeypatch.setenv('PWD', '/here')

    def run(*words):
        code = tool('demo_arguments').main(os.path.join(LAUNCH_FOLDER, 'demo.launch'), *words)
        return code, ''.join(capsys.readouterr())
    return run


def test_refused(checked):
    def line(words):
        code, output = checked(*shlex.split(words))
        assert code == 1 and output.count('\n') == 1
        return output.rstrip('\n')
    expected.check_cases('refused/demo.txt', line)


def test_help_lists_all_arguments_in_groups_with_their_defaults(checked):
    code, output = checked('--help')
    assert code == 0
    lines = output.splitlines()
    assert {'camera', 'simulator', 'more of simulator.launch'} <= set(lines)
    for arg in launch_arguments().values():
        name, default = arg.name, arg.default.replace('$(find img_recog)/', '')
        begin = lines.index('  ' + name if '$(' in default else '  {}:={}'.format(name, default))
        assert ' '.join(output.split('\n', begin + 1)[-1].split()).startswith(
            ' '.join(arg.doc.split())), name


@pytest.mark.parametrize('name', ['old', 'old.bag'])
def test_a_recording_replaces_no_file(checked, tmp_path, name):
    (tmp_path / 'old.bag').write_text('')
    assert checked('record:={}/{}'.format(tmp_path, name)) == (
        1, '[run] record: {}/old.bag exists; give another name, or remove it\n'.format(tmp_path))
    assert checked('--ros-args', 'record:={}/new'.format(tmp_path))[0] == 0
    (tmp_path / 'new.bag.active').write_text('')
    code, output = checked('record:={}/new'.format(tmp_path))
    assert code == 1
    assert output.startswith('[run] record: {}/new.bag.active exists: '.format(tmp_path))


@pytest.mark.parametrize('word, path', [
    ('camera:=a.mp4', '/here/a.mp4'), ('camera:=robot', 'robot'), ('colors:=/c', '/c'),
    ('camera:=RTSP://host/stream', 'RTSP://host/stream'), ('robots:=2', '2'),
    ('robots:=r.yaml', '/here/r.yaml'), ('urdf:=r.xacro a:=1', '/here/r.xacro a:=1'),
    ('world:=empty', 'empty'), ('world:=' + __file__, __file__), ('record:=none', 'none')])
def test_a_relative_path_starts_at_the_working_directory(monkeypatch, word, path):
    monkeypatch.setenv('PWD', '/here')
    arguments = tool('demo_arguments').Arguments(os.path.join(LAUNCH_FOLDER, 'demo.launch'))
    assert arguments.checked(['-p', '11399', word])[2].split(':=', 1)[1] == path


@pytest.mark.parametrize('words', [
    [name + ':=False' for name in SWITCHES],
    ('world:=empty', 'x_pos:=-1e-3', '--screen', 'gui:=1', 'record_size:=0', '__name:=x'),
    ['{}:={}'.format(each.name, each.default) for each in launch_arguments().values()
     if '$(' not in each.default]])
def test_accepted(checked, words):
    assert checked(*words) == (0, '')


@pytest.mark.parametrize('name, content, words', [
    ('urdf', None, 'cannot read the robot in FILE: No such file or directory; set urdf to '),
    ('urdf', '<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:foo/></robot>',
     'xacro cannot expand FILE: '),
    ('colors', 'colors: [blue\n',
     'cannot read the parameters in FILE: no YAML, line 2, column 1: '),
    ('camera', None, 'cannot open FILE: no such file; give a device, '),
    ('robots', None, 'robots: cannot read FILE: No such file or directory; give a number of'),
    ('world', '<sdf><world>',
     'xacro cannot expand FILE: not XML: it is empty, or ends at line 1 ')])
def test_a_file_that_roslaunch_cannot_load_is_refused_in_a_line(tmp_path, name, content, words):
    path = tmp_path / 'robot.xacro'
    if content:
        path.write_text(content)
    assert refusal(tool('demo').check_files, ['-p', '1', '{}:={}'.format(name, path)]).startswith(
        words.replace('FILE', str(path)))


def test_a_urdf_that_is_not_xml_is_refused_before_the_start(tmp_path):
    path = tmp_path / 'r.urdf'
    path.write_text('<robot name="r">')
    assert refusal(tool('demo').check_files, ['urdf:={}'.format(path)]).startswith(
        'cannot use the robot in {}: not XML: it is empty, or ends at line 1 before'.format(path))


@pytest.mark.parametrize('code', [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_of_the_log_is_refused_in_a_line(tmp_path, monkeypatch, code):
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'log'))
    demo = tool('demo')
    demo.check_log_folder()
    monkeypatch.setattr(demo.tempfile, 'TemporaryFile', mock.Mock(side_effect=OSError(code, 'no')))
    assert refusal(demo.check_log_folder) == (
        'cannot write the log in {}/log: no; free some space, or set ROS_HOME to another '
        'folder'.format(tmp_path))


def test_a_folder_of_the_log_that_cannot_be_made_is_left_to_the_nodes(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_LOG_DIR', '/proc/no/log')
    tool('demo').check_log_folder()
