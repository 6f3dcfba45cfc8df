"""The windows on a virtual display, checked by screenshots."""
import re
import subprocess

import cv2
import numpy as np
import pytest
from roslib.packages import find_node

from img_recog_helpers import pages
from img_recog_helpers.simulator_tools import Echo, Messages, burger
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.display
SIMULATOR = 'Bullet Physics'


def screenshot(path):
    """Return the RGB image in a file of the format of xwd, with 4 bytes for a pixel: B, G, R, 0.

    A program that takes one needs 0.3 s of CPU time.
    """
    data = np.fromfile(str(path), np.uint8)
    header = data[:100].view('>u4')
    begin, height, line = header[0] + 12 * header[19], header[5], header[12]
    return data[begin:begin + height * line].reshape(height, -1, 4)[..., 2::-1]


@pytest.fixture
def wait_shares(display):
    """A function that waits until a screenshot shows some colors as a condition wants it.

    colors: the lowest and highest RGB values (0 to 255) of each. is_good: called with the share of
    the pixels that each of them has.
    """
    def wait(colors, is_good):
        found = {}

        def shown():
            image = screenshot(display)[::2, ::2]
            found.update({name: float(((image >= low) & (image <= high)).all(axis=2).mean())
                          for name, (low, high) in colors.items()})
            return is_good(found)
        wait_for(shown, lambda: 'other shares of colors: {}'.format(found))
    return wait


def test_image_view_shows_the_blue_part(ros, wait_shares):
    ros.start_master()
    ros.start_node('usb_cam_node.py', '_video_device:=synthetic')
    ros.start_node('color_img_recog.py')
    ros.start(find_node('image_view', 'image_view')[0], 'image:=/blue_image')
    wait_shares({'blue': ((0, 40, 180), (60, 100, 255)), 'red': ((180, 0, 30), (255, 60, 90)),
                 'wall': ((200, 195, 185), (212, 205, 195))},
                lambda found: found['blue'] > 0.01 and found['red'] == found['wall'] == 0)


def article_commands(path):
    """Return the commands of this package in the table of a README, by the number of the terminal.

    Terminal 3 is that without a webcam, terminal 8 that without rqt_graph.
    """
    table, = [each for each in pages.tables(pages.read(path))
              if [row[0] for row in each.rows] == list('012345678')]
    spans = [re.findall('`([^`]+)`', row[2]) for row in table.rows]
    return [' '.join(found) if number == 3 else found[-1] for number, found in enumerate(spans)]


def test_all_terminals_of_the_article_run_together(ros, display, tmp_path):
    commands = article_commands('README.md')
    assert article_commands('README.ja.md') == commands
    commands[0] += ' -p {}'.format(ros.port)
    commands[2] = "script -qec '{}' /dev/null".format(commands[2])       # it needs a terminal
    terminals = []
    for command, is_ready in zip(commands[:8], (
            'started core service', 'simulating 1.0017 kg', 'w/x: faster', 'camera: synthetic',
            'blue=', *['Using transport "raw"'] * 3)):
        terminals.append(ros.start('bash', '-c', 'exec ' + command, cwd=str(tmp_path),
                                   stdin=subprocess.PIPE))
        terminals[-1].wait_output(is_ready)
    terminals[2].stdin.write(b'w')
    terminals[2].stdin.flush()
    terminals[2].wait_output('target: linear 0.01')
    terminals[1].wait_output('the robot drives forward')

    wanted = {'/usb_cam/image_raw': {'/color_extract', '/camera_window'},
              '/blue_image': {'/blue_window'}, '/red_image': {'/red_window'}}

    def subscribers():
        found = dict(ros.master().getSystemState('/test')[2][1])
        return {topic: set(found.get(topic, ())) for topic in wanted}
    wait_for(lambda: subscribers() == wanted, subscribers)
    graph = ros.start('bash', '-c', commands[8], cwd=str(tmp_path))
    assert graph.wait() == 0, graph.output
    assert '/blue_window' in (tmp_path / 'graph.svg').read_text()
    # a window whose name another one takes ends
    assert [each.output for each in terminals if not each.is_running()] == []
    assert subscribers() == wanted


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
    assert Messages(ros, '/usb_cam/image_raw').wait_more(1)[0].header.frame_id == 'usb_cam'
    wait_shares({'green': ((0, 180, 0), (20, 220, 20))}, lambda found: found['green'] > 0.25)


def test_the_simulators_window_shows_nothing_before_all_is_loaded(ros, display):
    ros.start_master()
    ros.set_parameters('/robot_description', burger())
    simulator = ros.start_node('pybullet_sim.py', '_gui:=true')
    shown = []

    def is_shown_for_a_while():
        image = screenshot(display)[:700, :1000].astype(int)
        is_background = np.abs(image - 178).max(axis=2) < 5
        assert (image.min(axis=2) > 240).mean() < 0.05      # the menus of PyBullet are white
        if 0.4 < is_background.mean() < 0.998:      # less, more: nothing yet
            shown.append(image)
        return len(shown) > 20
    wait_for(is_shown_for_a_while, 'the world')
    # nothing has moved; one of the images may be without shadows
    differing = (np.abs(shown[0] - shown[-1]).max(axis=2) > 60).mean()
    assert differing < 1e-4, 'share of the pixels: {}'.format(differing)
    assert 'argv' not in simulator.output and 'GL_VENDOR' not in simulator.output


def test_the_simulators_window_shows_the_world(ros, wait_shares):
    # alone: that gui:=true comes to it, test_optional_window.py holds
    ros.start_master()
    ros.set_parameters('/robot_description', burger())
    simulator = ros.start_node('pybullet_sim.py', '_gui:=true')
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
    simulator.wait_output('no window: .*the simulation goes on')
    Echo(ros, '/clock/clock').wait_more(2)
