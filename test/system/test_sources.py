"""The linters report nothing, and the launch arguments are documented."""
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog_testing.pages import ROOT

PROGRAMS = os.path.join(os.environ['CMAKE_PREFIX_PATH'].split(':')[0], 'lib', 'img_recog')


def run(*command):
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False)
    return done.returncode, done.stdout.decode()


def test_linters():
    code, output = run('./run', 'lint')
    assert code == 0, output


def test_every_launch_argument_is_documented():
    launch = ElementTree.parse(os.path.join(ROOT, 'launch', 'demo.launch')).getroot()
    names = {arg.get('name') for arg in launch.iterfind('.//arg[@default]')}
    code, output = run('roslaunch', '--ros-args', 'img_recog', 'demo.launch')
    assert code == 0, output
    documented = dict(re.findall(r'(?m)^  (\w+) \(default .*?\): (.+)$', output))
    assert {'camera', 'image_width', 'image_height', 'framerate', 'pixel_format',
            'camera_frame_id', 'camera_info_url', 'recognition', 'robots', 'simulator', 'teleop',
            'gui', 'image_view', 'world', 'allow_partial_world', 'urdf', 'x_pos', 'y_pos',
            'z_pos', 'yaw', 'real_time_factor', 'use_sim_time', 'view', 'colors',
            'cmd_vel_timeout', 'safe', 'respawn', 'robot_camera_frame', 'web', 'web_host',
            'web_port', 'record', 'record_size', 'rviz', 'rqt_graph', 'rqt_reconfigure',
            'lockstep', 'lockstep_sensors', 'lockstep_timeout', 'lockstep_at_timeout', 'paused',
            'vision', 'robot_state_publisher'} == names == set(documented)
    assert all(len(words) > 10 for words in documented.values()), documented


@pytest.mark.parametrize('arguments, nodes', [
    (['vision:=false'], {'gazebo', 'robot_state_publisher'}),
    (['vision:=false', 'camera:=synthetic'], {'gazebo', 'robot_state_publisher', 'usb_cam'}),
    ([], {'gazebo', 'robot_state_publisher', 'usb_cam', 'color_extract',
          'turtlebot3_teleop_keyboard', 'image_view', 'image_view_blue', 'image_view_red'})])
def test_nodes_of_the_demo_with_a_display(arguments, nodes):
    code, output = run('env', 'DISPLAY=:9', 'roslaunch', '--nodes', 'img_recog', 'demo.launch',
                       *arguments)
    assert (code, {line.strip('/') for line in output.split()}) == (0, nodes)


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
