"""Wrong input: one line names the error and the allowed values, and the exit code is not 0."""
import os
import re

import pytest
import yaml

from img_recog_helpers.simulator_tools import BURGER, burger

CAMERA_CASES = {
    'missing path': ('_video_device:=/no/such.mp4', '/no/such.mp4: no such file', 'synthetic'),
    'a number': ('_video_device:=0', 'video_device: got 0, allowed is a path like /dev/video0',
                 'synthetic'),
    'no camera': ('_video_device:=/dev/null', '/dev/null: no V4L2 capture device', 'have'),
    'a directory': ('_video_device:=/usr', '/usr: there is no image in it', 'synthetic'),
    'no video': ('_video_device:=' + BURGER, 'turtlebot3_burger.urdf: neither a video nor',
                 'synthetic'),
    'pixel format': ('_pixel_format:=mjpg', "/usb_cam/pixel_format: got 'mjpg'",
                     'grey, h264, mjpeg, rgb24, uyvy, yu12, yuvmono10, yuyv'),
    'io method': ('_io_method:=dma', "/usb_cam/io_method: got 'dma'", 'mmap, read, userptr'),
    'width': ('_image_width:=0', '/usb_cam/image_width: got 0', 'from 1 to'),
    'type': ('_image_height:=tall', "/usb_cam/image_height: got 'tall'", 'a whole number'),
    'rate': ('_framerate:=-1', '/usb_cam/framerate: got -1', 'a finite number from'),
    'calibration': ('_camera_info_url:=http://x', "camera_info_url: got 'http://x'", 'file://'),
}


@pytest.mark.parametrize('parameter, named, advice', list(CAMERA_CASES.values()),
                         ids=list(CAMERA_CASES))
def test_camera(roscore, parameter, named, advice):
    roscore.set_parameters('/usb_cam')
    arguments = [parameter]
    if 'video_device' not in parameter:
        arguments.append('_video_device:=synthetic')
    line = roscore.start_node('usb_cam_node.py', *arguments).fatal_line()
    assert named in line and advice in line, line


def test_camera_typo_is_a_warning(roscore):
    roscore.set_parameters('/usb_cam')
    camera = roscore.start_node('usb_cam_node.py', '_video_device:=synthetic', '_framrate:=10',
                                '_focus_absolute:=3')
    for name, meant in (('focus_absolute', 'focus'), ('framrate', 'framerate')):
        camera.wait_output(r'\[WARN\].*/usb_cam/{} is unknown .* did you mean {}\?'.format(
            name, meant))
    camera.wait_output('camera: synthetic scene')
    assert camera.interrupt() == 0


def test_camera_continues_without_a_calibration_that_does_not_parse(roscore, tmp_path):
    roscore.set_parameters('/usb_cam')
    path = tmp_path / 'camera.yaml'
    path.write_text('image_width: 640\n')
    camera = roscore.start_node('usb_cam_node.py', '_video_device:=synthetic',
                                '_camera_info_url:=file://{}'.format(path))
    line = camera.wait_output(r'\[ERROR\].*').group()
    assert str(path) in line and 'image_height' in line, line
    camera.wait_output('camera: synthetic scene')


def without(tag, name):
    return re.sub(r'(?s)<{0} name="{1}".*?</{0}>'.format(tag, name), '', burger())


SIMULATOR_CASES = {
    'no description': (None, '', 'robot_description: got none', 'textfile'),
    'no XML': (lambda: '<robot', '', 'cannot use the robot in robot_description: not XML', 'urdf'),
    'no URDF': (lambda: '<sdf/>', '', 'root element <sdf>', '<robot>'),
    'no wheel': (lambda: burger().replace('joint name="wheel_left', 'joint name="left'), '',
                 'no movable joint wheel_left_joint', 'wheel_right_joint'),
    'lost link': (lambda: without('link', 'base_scan'), '', 'base_scan', 'does not exist'),
    'no mass': (lambda: burger().replace('value="0.82573504"', 'value="-1"'), '',
                'mass of link base_link: got -1', 'more than 0'),
    'NaN mass': (lambda: burger().replace('value="0.82573504"', 'value="nan"'), '',
                 'mass of link base_link', 'finite'),
    'position': (burger, '_x_pos:=here', "/gazebo/x_pos: got 'here'", 'a finite number'),
    'factor': (burger, '_real_time_factor:=-1', '/gazebo/real_time_factor: got -1',
               'from 0.001 to 1000, or 0'),
    'world': (burger, '_world:=mars', "world: got 'mars'", 'turtlebot3_world, empty'),
    'broken world': (burger, '_world:=' + os.path.abspath(__file__), 'world:', 'URDF'),
    'period': (burger, '_odometry_period_s:=0.0335', 'odometry_period_s: got 0.0335',
               '0.033 or 0.034'),
}


@pytest.mark.parametrize('urdf, parameter, named, advice', list(SIMULATOR_CASES.values()),
                         ids=list(SIMULATOR_CASES))
def test_simulator(roscore, urdf, parameter, named, advice):
    roscore.set_parameters('/gazebo')
    roscore.set_parameters('/robot_description', urdf and urdf())
    line = roscore.start_node('pybullet_sim.py', *filter(None, [parameter])).fatal_line()
    assert named in line and advice in line, line


COLOR_CASES = {
    'no colors': ('colors: []', '/color_extract/colors: got []', 'like [blue, red]'),
    'a color without hues': ('colors: [green]', '/color_extract/green_hue_min: got nothing',
                             'from 0 to 180'),
    'bounds': ('blue_value_min: 200\nblue_value_max: 100',
               '/color_extract/blue_value_min: got 200', 'at most blue_value_max, which is 100'),
    'a limit': ('red_area_limit: -1', '/color_extract/red_area_limit: got -1', 'at least 0'),
    'a command': ('red_linear_x: .nan', '/color_extract/red_linear_x: got nan', 'finite'),
    'transport': ('image_transport: theora', "image_transport: got 'theora'", 'raw, compressed'),
    'no topic': ("blue_image_topic: 'a b'", "/color_extract/blue_image_topic: got 'a b'",
                 'a valid topic name'),
    'its own input': ('blue_image_topic: /usb_cam/image_raw',
                      "blue_image_topic: got '/usb_cam/image_raw'", 'does not already use'),
    'one topic twice': ('red_image_topic: blue_image',
                        "/color_extract/red_image_topic: got 'blue_image'",
                        'does not already use'),
    'an empty file': ('', 'colors.yaml: got nothing', 'colors: [blue, red]'),
}


def recognition(roscore, tmp_path, text):
    """Start color_extract with the parameters in a file."""
    path = tmp_path / 'colors.yaml'
    path.write_text(text)
    roscore.set_parameters('/color_extract', yaml.safe_load(text))
    # of an empty file nothing is loaded, so pass its name too, like the demo
    return roscore.start_node('color_img_recog.py',
                              *([] if text else ['_colors_file:={}'.format(path)]))


@pytest.mark.parametrize('text, named, advice', list(COLOR_CASES.values()), ids=list(COLOR_CASES))
def test_colors(roscore, tmp_path, text, named, advice):
    line = recognition(roscore, tmp_path, text).fatal_line()
    assert named in line and advice in line, line


def test_unknown_parameters_of_color_extract_are_warnings(roscore, tmp_path):
    roscore.set_parameters('/color_extract')
    node = roscore.start_node('color_img_recog.py', '_blue_hue_mni:=10', '_green_hue_min:=40')
    node.wait_output(r'\[WARN\].*/color_extract/blue_hue_mni .*did you mean blue_hue_min\?')
    node.wait_output(r'\[WARN\].*/color_extract/green_hue_min: there is no color green, the '
                     r'colors are blue, red; add it to colors: \[blue, red, green\]')
    assert node.interrupt() == 0
