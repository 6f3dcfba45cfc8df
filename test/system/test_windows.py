"""The windows on a virtual display, checked by screenshots."""
import os
import re
import subprocess

import cv2
import numpy as np
import pytest

from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.display
SIMULATOR = 'Bullet Physics'


@pytest.fixture
def display(ros):
    """A virtual display; ros.env has its name."""
    reader, writer = os.pipe()
    # without -noreset it ends the connections of new clients when the last one has gone
    server = ros.start('Xvfb', '-displayfd', writer, '-noreset', '-screen', '0', '1100x800x24',
                       '-nolisten', 'tcp', pass_fds=[writer])
    os.close(writer)
    with os.fdopen(reader) as file:
        number = file.readline().strip()
    assert number, server.output
    ros.env['DISPLAY'] = ':' + number
    return ros.env['DISPLAY']


@pytest.fixture
def wait_shares(ros, display, tmp_path):
    """A function that waits until a screenshot shows some colors as a condition wants it.

    colors: the lowest and highest RGB values (0 to 255) of each. is_good: called with the share of
    the pixels that each of them has.
    """
    def wait(colors, is_good):
        path, found = str(tmp_path / 'display.ppm'), {}
        command = ['import', '-window', 'root', '-depth', '8', path]

        def shown():
            if subprocess.run(command, env=ros.env, check=False).returncode != 0:
                return False
            image = cv2.imread(path)[..., ::-1]
            found.update({name: float(((image >= low) & (image <= high)).all(axis=2).mean())
                          for name, (low, high) in colors.items()})
            return is_good(found)
        wait_for(shown, lambda: 'other shares of colors: {}'.format(found))
    return wait


def test_image_view_shows_the_blue_part(ros, wait_shares):
    demo = ros.demo('simulator:=false', 'gui:=false', 'image_view:=false', 'teleop:=false',
                    'image_width:=640', 'image_height:=480')
    demo.wait_output('camera: synthetic')
    ros.start('rosrun', 'image_view', 'image_view', 'image:=/blue_image')
    wait_shares({'blue': ((0, 40, 180), (60, 100, 255)), 'red': ((180, 0, 30), (255, 60, 90))},
                lambda found: found['blue'] > 0.01 and found['red'] == 0)


USB_CAM_LAUNCH = """<launch>
  <node name="usb_cam" pkg="img_recog" type="usb_cam_node.py" output="screen">
    <param name="video_device" value="{}"/>
    <param name="image_width" value="640"/>
    <param name="image_height" value="480"/>
    <param name="pixel_format" value="yuyv"/>
    <param name="color_format" value="yuv422p"/>
    <param name="camera_frame_id" value="usb_cam"/>
    <param name="io_method" value="mmap"/>
  </node>
  <node name="image_view" pkg="image_view" type="image_view" respawn="false" output="screen">
    <remap from="image" to="/usb_cam/image_raw"/>
    <param name="autosize" value="true"/>
  </node>
</launch>"""


def test_a_launch_file_like_that_of_usb_cam_shows_the_image(ros, wait_shares, tmp_path):
    picture, launch = str(tmp_path / 'picture.png'), tmp_path / 'usb_cam.launch'
    assert cv2.imwrite(picture, np.full((480, 640, 3), (0, 200, 0), np.uint8))
    launch.write_text(USB_CAM_LAUNCH.format(picture))
    ros.roslaunch(launch).wait_output('camera: image')
    ros.wait_run('frame_id: "usb_cam"', 'rostopic', 'echo', '-n', '1', '/usb_cam/image_raw/header')
    wait_shares({'green': ((0, 180, 0), (20, 220, 20))}, lambda found: found['green'] > 0.25)


def test_the_simulators_window_shows_the_world(ros, wait_shares):
    demo = ros.demo('gui:=true', 'vision:=false', 'camera:=none')
    colors = {'green': ((0, 90, 0), (60, 255, 60)), 'white': ((205, 205, 205), (255, 255, 255)),
              'wall': ((20, 20, 20), (90, 90, 90)), 'floor': ((130, 130, 130), (190, 190, 190))}
    wait_shares(colors, lambda found: found['green'] > 0.03 and found['white'] > 0.0005
                and found['wall'] > 0.01 and found['floor'] > 0.4)

    # the simulation continues when its connection to the display is closed
    windows = subprocess.run(['xwininfo', '-root', '-tree'], env=ros.env, stdout=subprocess.PIPE,
                             check=False).stdout.decode()
    assert SIMULATOR in windows
    window = re.search(r'(0x[0-9a-f]+) "{}'.format(SIMULATOR), windows).group(1)
    subprocess.run(['xkill', '-id', window], env=ros.env, check=True, stdout=subprocess.DEVNULL)
    demo.wait_output('no window: .*the simulation goes on')
    ros.wait_run('clock:', 'rostopic', 'echo', '-n', '1', '/clock')
