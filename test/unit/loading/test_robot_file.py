"""Files of robots: URDF as it is, xacro expanded by ROS 1's command, by Python's package, or not.
"""
import os
import pathlib
import stat
import subprocess
import sys
import types
from importlib import util

import pytest

from img_recog.checks import check_jobs
from img_recog.formats import world_file
from img_recog.loading import robot_file
from img_recog.model import SPHERE, Shape
from img_recog_helpers import refusals

URDF = '<robot name="r"><link name="a"/></robot>'
XACRO = '''<robot name="box" xmlns:xacro="http://ros.org/wiki/xacro">
  <xacro:arg name="side" default="0.4"/>
  <xacro:include filename="$(find toy_description)/urdf/common.xacro"/>
  <link name="base"><xacro:shape half="${0.5 * $(arg side)}"/></link>
</robot>'''
COMMON = '''<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:macro name="shape" params="half">
  <visual><geometry><sphere radius="${half}"/></geometry></visual></xacro:macro></robot>'''
OUR_PACKAGE = pathlib.Path(__file__).parents[3] / 'cmake' / 'xacro' / 'package.xml'
needs_module = pytest.mark.skipif(
    util.find_spec('xacro') is None or util.find_spec('xacro.substitution_args') is None,
    reason="Python's package xacro is not installed")


def add_package(folder, name):
    (folder / name).mkdir(parents=True)
    (folder / name / 'package.xml').write_text(
        '<package><name>{}</name><version>1.0.0</version><description>d</description>'
        '<maintainer email="a@b.c">a</maintainer><license>BSD</license></package>'.format(name))
    return folder / name


@pytest.fixture
def box(tmp_path, monkeypatch):
    """The path of a xacro file that includes another one from a ROS package."""
    package = add_package(tmp_path / 'packages', 'toy_description')
    (package / 'urdf').mkdir()
    (package / 'urdf' / 'common.xacro').write_text(COMMON)
    path = tmp_path / 'box.urdf.xacro'
    path.write_text(XACRO)
    monkeypatch.setenv('ROS_PACKAGE_PATH', str(tmp_path / 'packages'))
    return str(path)


@pytest.fixture
def command(tmp_path, monkeypatch):
    """A function that puts ROS 1's package xacro, with a command of this script, on the paths."""
    def install(script):
        add_package(tmp_path / 'packages', 'xacro')
        folder = tmp_path / 'bin'
        folder.mkdir()
        (folder / 'xacro').write_text('#!/bin/sh\n' + script)
        (folder / 'xacro').chmod(stat.S_IRWXU)
        monkeypatch.setenv('ROS_PACKAGE_PATH', str(tmp_path / 'packages'))
        monkeypatch.setenv('PATH', '{}:{}'.format(folder, os.environ['PATH']))
    return install


def refusal(path):
    line = refusals.refusal(robot_file.read, path, '--urdf')
    assert path in line
    return line


@pytest.mark.parametrize('content, text', [
    (URDF.encode(), URDF),
    (b'<robot name="\xe9"/>', '<robot name="\u00e9"/>'),        # no UTF-8, so Latin-1
    (b'<robot', '<robot'),      # no XML, which is left to those who know what it shall be
    (bytes(range(256)), None)])
def test_a_urdf_is_read_as_it_is_if_it_is_text(tmp_path, content, text):
    path = tmp_path / 'robot.urdf'
    path.write_bytes(content)
    if text is None:
        assert 'it is not a text file; set --urdf' in refusal(str(path))
    else:
        assert robot_file.read(str(path)) == text


@pytest.mark.parametrize('name', ['no.urdf', 'no.urdf.xacro'])
def test_missing_file_names_the_option(tmp_path, name):
    words = refusal(str(tmp_path / name))
    assert words.endswith('No such file or directory; set --urdf to a URDF or xacro file')
    assert refusals.refusal(robot_file.read, str(tmp_path / name)).endswith(
        'No such file or directory; set urdf to a URDF or xacro file')


def test_command_of_ros_1_is_used_where_it_is_installed(box, command):
    command('echo "<robot name=\\"$(basename $1)\\"/>"; shift; echo "$@"')
    assert robot_file.read(box + ' a:=1 b=x:=y') == (
        '<robot name="box.urdf.xacro"/>\na:=1 b:=x:=y\n')


def test_command_of_our_devel_space_is_not_that_of_ros_1(box, command, tmp_path, monkeypatch):
    command('echo "<robot/>"')
    (tmp_path / 'devel' / 'bin').mkdir(parents=True)
    (tmp_path / 'devel' / 'bin' / 'xacro').write_text('#!/bin/sh\nexit 1')
    (tmp_path / 'devel' / 'bin' / 'xacro').chmod(stat.S_IRWXU)
    manifest = add_package(tmp_path / 'devel' / 'share', 'xacro') / 'package.xml'
    manifest.write_text(OUR_PACKAGE.read_text())
    monkeypatch.setenv('PATH', '{}/devel/bin:{}'.format(tmp_path, os.environ['PATH']))
    assert robot_file.read(box) == '<robot/>\n'


@needs_module
def test_package_xacro_of_this_one_is_not_that_of_ros_1(box, command):
    """Then a xacro in PATH may be any other, which does not find ROS 1's packages."""
    command('exit 1')
    manifest = pathlib.Path(os.environ['ROS_PACKAGE_PATH'], 'xacro', 'package.xml')
    manifest.write_text(OUR_PACKAGE.read_text())
    assert '<sphere radius="0.2"/>' in robot_file.read(box)


def test_command_has_a_minute(box, command, monkeypatch):
    command('')
    given = {}

    def run(words, **options):
        given.update(options, words=words)
        raise subprocess.TimeoutExpired(words, 60)
    monkeypatch.setattr(subprocess, 'run', run)
    assert refusal(box).startswith('xacro cannot expand {}: Command '.format(box))
    assert given['timeout'] == 60.0 and given['check'] is True
    assert given['words'][1:] == [box] and given['words'][0].endswith('/bin/xacro')


def test_command_that_cannot_be_run_is_a_line_with_its_reason(box, command, tmp_path):
    command('')
    (tmp_path / 'bin' / 'xacro').write_text('#!/no/such\n')
    assert refusal(box) == 'xacro cannot expand {}: No such file or directory'.format(box)


def test_command_that_fails_is_a_line_with_its_reason(box, command):
    command('echo "undefined\nargument: side" >&2; exit 2')
    assert refusal(box) == 'xacro cannot expand {}: undefined argument: side'.format(box)


def test_command_that_is_not_of_ros_1_is_not_used(box, command, monkeypatch):
    command('echo wrong')
    monkeypatch.setenv('ROS_PACKAGE_PATH', '')
    monkeypatch.setitem(sys.modules, 'xacro', None)
    assert 'xacro cannot be loaded' in refusal(box)


@pytest.mark.parametrize('content, reason', [
    ('raise ImportError("no lib\\nxml2")', 'no lib xml2'),
    ('', "No module named 'xacro.substitution_args'; 'xacro' is not a package")])
def test_without_xacro_the_line_says_why_and_what_to_do(box, tmp_path, monkeypatch, content,
                                                        reason):
    for name in [name for name in sys.modules if name.partition('.')[0] == 'xacro']:
        monkeypatch.delitem(sys.modules, name)
    (tmp_path / 'xacro.py').write_text(content + '\n')
    monkeypatch.syspath_prepend(str(tmp_path))
    words = refusal(box)
    assert 'it is a xacro file, and xacro cannot be loaded: {}; install it'.format(reason) in words
    assert 'pip install xacro' in words and 'xacro {} > robot.urdf'.format(box) in words
    sys.modules.pop('xacro', None)


@needs_module
def test_module_expands_macros_arguments_and_packages_of_ros_1(box):
    text = robot_file.read(box)
    assert '<sphere radius="0.2"/>' in text and 'xacro:' not in text
    assert 'ament_index_python' not in sys.modules


@needs_module
def test_a_world_is_expanded_like_a_robot(box, tmp_path):
    world = world_file.read(box, {}, read_file=robot_file.read_any)
    look, = world.trees[0].model.links[0].looks
    assert world.name == 'box' and look.shape == Shape(SPHERE, (0.2,))
    assert 'it contains xacro' in refusals.refusal(world_file.read, box, {})
    pathlib.Path(box).write_text('<sdf xmlns:xacro="http://ros.org/wiki/xacro"><xacro:if value="0"'
                                 '/></sdf>')
    assert world_file.read(box, {}, read_file=robot_file.read_any).trees == ()
    pathlib.Path(box).write_text('<robot')
    assert refusals.refusal(world_file.read, box, {}, read_file=robot_file.read_any).startswith(
        'xacro cannot expand ' + box)


@needs_module
def test_module_leaves_the_packages_of_ros_2_as_they_were(box, monkeypatch):
    others = {name: types.ModuleType(name)
              for name in ('ament_index_python', 'ament_index_python.packages')}
    for name, module in others.items():
        monkeypatch.setitem(sys.modules, name, module)
    assert '<sphere radius="0.2"/>' in robot_file.read(box)
    assert {name: sys.modules[name] for name in others} == others


INCLUDE = '<xacro:include filename="$(find {})/a.xacro"/>'
# the texts of the file and of the one that it includes; words of the line, and its end
PROBLEMS = {
    'no XML': ('<robot', COMMON, 'unclosed token', ''),
    'a name': (XACRO.replace('0.5 *', 'height *'), COMMON, "'height' is not defined", ''),
    'an argument': (XACRO.replace('arg side', 'arg width'), COMMON, 'width', ''),
    'a package': (XACRO.replace('toy', 'lost'), COMMON,
                  'there is no ROS package lost_description; source the workspace', ''),
    'all packages': (
        XACRO.replace('<link', INCLUDE.format('lost_arm') + '<!-- $(find nobody) -->'
                      + INCLUDE.format('lost_base') + '<link'), COMMON,
        'there is no ROS package lost_arm, lost_base; source', ''),
    'a name in a macro': (XACRO, COMMON.replace('${half}', '${whole}'),
                          "name 'whole' is not defined",
                          'when instantiating macro: shape ({common}), in file: {box}'),
    'no XML in what is included': (XACRO, COMMON.replace('</visual>', ''),
                                   'mismatched tag: line 2, column ',
                                   'when processing file: {common}, included from: {box}')}


@needs_module
@pytest.mark.parametrize('text, included, words, end', list(PROBLEMS.values()), ids=list(PROBLEMS))
def test_module_that_fails_is_a_line_with_its_reason(box, tmp_path, text, included, words, end):
    common = tmp_path / 'packages' / 'toy_description' / 'urdf' / 'common.xacro'
    common.write_text(included)
    pathlib.Path(box).write_text(text)
    line = refusal(box)
    assert line.startswith('xacro cannot expand ') and words in line
    assert line.endswith(end.format(common=common, box=box))


@needs_module
@pytest.mark.parametrize('arguments', [' side:=0.8', '  side=0.8 '])
def test_arguments_of_xacro_stand_after_the_file(box, arguments):
    assert 'radius="0.4"' in robot_file.read(box + arguments)


def test_a_urdf_has_no_arguments(tmp_path):
    (tmp_path / 'my.urdf').write_text(URDF)
    line = refusals.refusal(robot_file.read, '{} arm:=true'.format(tmp_path / 'my.urdf'))
    assert 'it is no .xacro file, and has no argument arm:=true; set urdf to the file' in line
    (tmp_path / 'my.urdf a=b').write_text(URDF)
    assert robot_file.read(str(tmp_path / 'my.urdf a=b')) == URDF


@needs_module
def test_packages_of_a_file_before_are_not_named(box, tmp_path):
    common = tmp_path / 'packages' / 'toy_description' / 'urdf' / 'common.xacro'
    common.write_text(COMMON.replace('<visual>', '<visual name="$(find lost_first)">'))
    assert 'package lost_first; source' in refusal(box)
    pathlib.Path(box).write_text(XACRO.replace('toy_description', 'lost_second'))
    assert 'package lost_second; source' in refusal(box)


def test_program_prints_the_urdf_or_one_line(tmp_path, monkeypatch, capsys, caplog):
    path = tmp_path / 'robot.urdf'
    path.write_text(URDF)
    monkeypatch.setattr(sys, 'argv', ['robot_description.py', str(path)])
    assert check_jobs.main('robot_description.py') == 0 and capsys.readouterr().out == URDF + '\n'
    monkeypatch.setattr(sys, 'argv', ['robot_description.py', str(tmp_path / 'no.urdf')])
    assert check_jobs.main('robot_description.py') == 1
    assert len(caplog.messages) == 1 and '\n' not in caplog.text.strip()
    for arguments in ([], [str(path), 'more']):
        monkeypatch.setattr(sys, 'argv', ['/bin/robot_description.py', *arguments])
        with pytest.raises(SystemExit, match='2'):
            check_jobs.main('robot_description.py')
        assert capsys.readouterr().err.startswith('usage: robot_description.py [-h] FILE\n')
