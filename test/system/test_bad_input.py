"""Wrong input: one line names the error and the allowed values, and the exit code is not 0."""
import glob
import os
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog_helpers.launch_config import launch_config
from img_recog_helpers.pages import LAUNCH_FOLDER
from img_recog_helpers.simulator_tools import burger

NODES = '/usb_cam', '/gazebo', '/color_extract', '/turtlebot3_teleop_keyboard'
# a parameter and a value for each of the ways to a refusal; the unit tests have the values
CASES = {
    'no source': ('usb_cam_node.py', ['_video_device:=/no/such.mp4'],
                  '/no/such.mp4: no such file', 'synthetic'),
    'a width': (
        'usb_cam_node.py', ['_image_width:=0', '_camera_name:=5'],
        '/usb_cam/image_width: got 0, allowed is a whole number', 'from 1 to 16384'),
    'a calibration': ('usb_cam_node.py',
                      ['_camera_info_url:=http://x', '_video_device:=synthetic'],
                      "camera_info_url: got 'http://x'", 'file://'),
    'a number': ('pybullet_sim.py', ['_real_time_factor:=-1'],
                 '/gazebo/real_time_factor: got -1', 'from 0.001 to 1000, or 0'),
    'a world': ('pybullet_sim.py', ['_world:=' + os.path.abspath(__file__)], 'world:', 'URDF'),
    'colors': ('color_img_recog.py', ['_colors:=[green]'],
               '/color_extract/green_hue_min: got nothing', 'from 0 to 180'),
    'a limit': ('teleop_key.py', ['_max_linear_velocity:=fast'],
                "max_linear_velocity: got 'fast'", 'a finite number'),
    'an integer of more than 32 bits': (
        'teleop_key.py', ['_max_linear_velocity:=99999999999'],
        'parameter ~max_linear_velocity: got 99999999999', 'at most 32 bits'),
    'integers of more than 32 bits': ('color_img_recog.py', ['_colors:=[1, -2147483649]'],
                                      'colors: got [1, -2147483649]', 'at most 32 bits'),
    'a value that is not sent': ('usb_cam_node.py', ['_framerate:=null'],
                                 'framerate: got None', 'numbers'),
    'no YAML': ('usb_cam_node.py', ['_framerate:=[1'], 'invalid command-line parameters', ''),
    'no topic': ('color_img_recog.py', ["_blue_image_topic:=a b"],
                 "/color_extract/blue_image_topic: got 'a b'", 'a valid topic name'),
    'its own input': ('color_img_recog.py', ['_blue_image_topic:=/usb_cam/image_raw'],
                      "blue_image_topic: got '/usb_cam/image_raw'", 'does not already use'),
    'one topic twice': ('color_img_recog.py', ['_red_image_topic:=blue_image'],
                        "/color_extract/red_image_topic: got 'blue_image'",
                        'does not already use')}


@pytest.mark.parametrize('script, arguments, named, advice', list(CASES.values()), ids=list(CASES))
def test_one_line_names_it(roscore, script, arguments, named, advice):
    for node in NODES:
        roscore.set_parameters(node)
    roscore.set_parameters('/robot_description', burger())
    line = roscore.start_node(script, *arguments).fatal_line()
    assert named in line and advice in line, line


def test_values_of_another_type_leave_the_defaults_of_usb_cam_with_a_line_each(roscore):
    roscore.set_parameters('/usb_cam')
    roscore.set_parameters('/usb_cam/image_raw/compressed',
                           {'jpeg_quality': 200, 'png_level': '1'})
    camera = roscore.start_node('usb_cam_node.py', '_video_device:=synthetic', '_framerate:=10',
                                '_camera_name:=5', '_autofocus:=1', '_brightness:=1.5')
    for line in ("/camera_name: got 5, allowed is a name .*; using 'head_camera'",
                 '/autofocus: got 1, allowed is true or false; using False',
                 '/brightness: got 1.5, allowed is a whole number at least -1; using 2',
                 '/image_raw/compressed/jpeg_quality: got 200, allowed is .* 100; using 100',
                 "/image_raw/compressed/png_level: got '1', allowed is .* 9; using 9"):
        camera.wait_output(r'\[WARN\].* parameter /usb_cam' + line)
    camera.wait_output('camera: synthetic scene')


def test_roslaunch_starts_nothing_if_the_recording_cannot_be_written(capfd, tmp_path, monkeypatch):
    monkeypatch.setenv('PWD', str(tmp_path))
    for bag in 'a.bag', str(tmp_path / 'a b.bag'):
        assert [node.name for node in launch_config('record.launch', 'record:=' + bag).nodes] == [
            'record']
    for bag in '/no such/x.bag', 'no/x.bag':
        with pytest.raises(Exception, match='record_folder'):
            launch_config('record.launch', 'record:=' + bag)
        assert 'record: {} cannot be written; give '.format(bag) in capfd.readouterr().err


def test_roslaunch_starts_nothing_with_an_integer_of_more_than_32_bits():
    numbers = {(os.path.basename(path), each.get('value')[len('$(arg '):-1])
               for path in glob.glob(LAUNCH_FOLDER + '/*.launch')
               for each in ElementTree.parse(path).iter('param')
               if each.get('type') is None and each.get('value') is not None}
    assert len(numbers) >= 16
    numbers |= {('record.launch', 'record_size'), ('demo.launch', 'z_pos')}
    for number, (file, name) in enumerate(sorted(numbers)):
        value = ('2147483648', '-99999999999', '+' + 400 * '9')[number % 3]
        with pytest.raises(SystemExit) as caught:
            launch_config(file, 'robots:=2', '{}:={}'.format(name, value))
        assert str(caught.value) == '{}: got {}, allowed are integers of at most 32 bits'.format(
            name, value)
    launch_config('simulator.launch', 'x_pos:=2147483647', 'y_pos:=1e99', 'yaw:=+-3', 'z_pos:=up')
    launch_config('record.launch', 'record:=20261231235959')


def test_no_robot(roscore):
    roscore.set_parameters('/gazebo')
    roscore.set_parameters('/robot_description')
    line = roscore.start_node('pybullet_sim.py').fatal_line()
    assert 'robot_description: got none' in line and 'textfile' in line, line


def test_camera_continues_with_typos_and_a_calibration_that_does_not_parse(roscore, tmp_path):
    roscore.set_parameters('/usb_cam')
    path = tmp_path / 'camera.yaml'
    path.write_text('image_width: 640\n')
    camera = roscore.start_node('usb_cam_node.py', '_video_device:=synthetic', '_framrate:=10',
                                '_focus_absolute:=3', '_camera_info_url:=file://{}'.format(path))
    for name, meant in (('focus_absolute', 'focus'), ('framrate', 'framerate')):
        camera.wait_output(r'\[WARN\].*/usb_cam/{} is unknown .* did you mean {}\?'.format(
            name, meant))
    line = camera.wait_output(r'\[ERROR\].*').group()
    assert str(path) in line and 'image_height' in line, line
    camera.wait_output('camera: synthetic scene')
    assert camera.interrupt() == 0


def test_unknown_parameters_of_color_extract_are_warnings(roscore):
    roscore.set_parameters('/color_extract')
    node = roscore.start_node('color_img_recog.py', '_blue_hue_mni:=10', '_green_hue_min:=40')
    node.wait_output(r'\[WARN\].*/color_extract/blue_hue_mni .*did you mean blue_hue_min\?')
    node.wait_output(r'\[WARN\].*/color_extract/green_hue_min: there is no color green, the '
                     r'colors are blue, red; add it to colors: \[blue, red, green\]')
    assert node.interrupt() == 0
