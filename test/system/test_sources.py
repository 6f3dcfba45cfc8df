"""The linters report nothing, and the launch arguments are documented."""
import os
import subprocess

import pytest
from roslaunch.node_args import get_node_list

from img_recog_helpers.launch_config import launch_config
from img_recog_helpers.pages import LAUNCH_FOLDER, ROOT, tool

launch_files = tool('launch_files')
PROGRAMS = os.path.join(os.environ['CMAKE_PREFIX_PATH'].split(':')[0], 'lib', 'img_recog')


def run(*command):
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False)
    return done.returncode, done.stdout.decode()


def test_linters():
    code, output = run('./run', 'lint')
    assert code == 0, output


def test_every_launch_argument_is_documented_and_has_one_default():
    defaults = {}
    for file in sorted(os.listdir(LAUNCH_FOLDER)):
        for name, argument in launch_files.arguments(launch_files.read(
                os.path.join(LAUNCH_FOLDER, file))).items():
            assert len(argument.doc) > 10, (file, name)
            defaults.setdefault(name, {}).setdefault(argument.default, []).append(file)
    # of the parts that mean several robots, real ones, or what the demo decides
    different = {'camera', 'gui', 'name', 'record', 'recognition', 'robots', 'safe', 'teleop',
                 'use_sim_time'}
    assert {name for name, found in defaults.items() if len(found) > 1} <= different, defaults


def test_the_demo_has_few_arguments_and_no_node():
    demo = launch_files.read(os.path.join(LAUNCH_FOLDER, 'demo.launch'))
    assert len(launch_files.arguments(demo)) <= 25
    assert demo.find('.//node') is None


@pytest.mark.parametrize('arguments, nodes', [
    (['vision:=false'], {'gazebo', 'robot_state_publisher'}),
    (['vision:=false', 'camera:=synthetic'], {'gazebo', 'robot_state_publisher', 'usb_cam'}),
    ([], {'gazebo', 'robot_state_publisher', 'usb_cam', 'color_extract',
          'turtlebot3_teleop_keyboard', 'image_view', 'image_view_blue', 'image_view_red'})])
def test_nodes_of_the_demo_with_a_display(arguments, nodes, monkeypatch):
    monkeypatch.setenv('DISPLAY', ':9')
    # as roslaunch --nodes does
    found = get_node_list(launch_config('demo.launch', *arguments))
    assert {name.strip('/') for name in found} == nodes


def test_cmake_lists_is_short():
    with open(os.path.join(ROOT, 'CMakeLists.txt')) as file:
        assert len(file.readlines()) < 60


def test_rosrun_finds_each_script_once():
    """It also finds executable files in the source folder, and asks which one is meant."""
    folder = os.path.join(ROOT, 'scripts')
    assert not [name for name in os.listdir(folder)
                if os.stat(os.path.join(folder, name)).st_mode & 0o111]
    for name in ('color_img_recog.py', 'robots.py'):
        code, output = run('rosrun', '--prefix', 'echo', 'img_recog', name)
        assert (code, output) == (0, '{}/{}\n'.format(PROGRAMS, name))
