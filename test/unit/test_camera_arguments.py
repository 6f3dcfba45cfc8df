"""Size and rate of images have the same ranges for all who read them, and cameras one name."""
import argparse
import os
import types
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.batch import sweep_file
from img_recog.camera import selection
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.errors import UserError, one_line
from img_recog.nodes.robots import robot_list
from img_recog.nodes.robots.robots_node import ManagerSettings, RobotsNode
from img_recog.replay import job
from img_recog.settings import from_mapping
from img_recog.simulation.simulation_settings import CameraSettings, ViewSettings
from img_recog_helpers.pages import ROOT

WIDTH, HEIGHT, RATE = 'image_width', 'image_height', 'framerate'
OF_ROBOT = {WIDTH: 'camera_width', HEIGHT: 'camera_height', RATE: 'camera_rate'}
# lowest, highest, one below and one above
EXISTS, DRAWN, RATES = (1, 16384, 0, 16385), (16, 4096, 15, 4097), (0.01, 1000, 0.009, 1001)


def usb_cam(device):
    def read(name, value, _):
        # it is known only when the node starts
        selection.resolve_auto(from_mapping(UsbCamSettings, {'video_device': device, name: value}))
    return read


def gazebo(name, value, _):
    from_mapping(CameraSettings, {OF_ROBOT[name]: value})


def view(name, value, _):
    from_mapping(ViewSettings, {name.replace('image', 'view'): value})


def sweep(name, value, folder):
    path = folder / 'sweep.yaml'
    path.write_text('parameters: {{goal: a, {}: {}}}\n'.format(OF_ROBOT[name], value))
    sweep_file.read(str(path))


def robots(camera):
    """Read a list of robots in which one has a value, and a list of robots that all have it."""
    def read(name, value, folder):
        (folder / 'video.mp4').write_bytes(b'')
        path = folder / 'robots.yaml'
        path.write_text('- {{name: a, camera: {}, {}: {}}}\n'.format(camera, name, value))
        given = robot_list.read_robots(str(path), {}, str).problems
        try:
            robot_list.read_robots('2', {'camera': camera, name: value}, str)
            assert not given
        except UserError as error:
            assert given == {'a': one_line(error)}
            raise
    return read


def replay(name, value, _):
    options = job.options_of(['a.mp4', '--{}'.format(name), str(value)])
    assert getattr(options, name) == value


READERS = {
    'usb_cam of a device': (usb_cam('/dev/video0'), EXISTS),
    'usb_cam of a video or images': (usb_cam('a.mp4'), EXISTS),
    'usb_cam of a stream': (usb_cam('rtsp://host/a'), EXISTS),
    'usb_cam of the synthetic scene': (usb_cam('synthetic'), DRAWN),
    'usb_cam without a device': (usb_cam('auto'), DRAWN),
    'gazebo': (gazebo, DRAWN), 'sweep file': (sweep, DRAWN),
    'robots with a video': (robots('video.mp4'), EXISTS),
    'robots with a stream': (robots('rtsp://host/a'), EXISTS),
    'robots with the synthetic scene': (robots('synthetic'), DRAWN),
    'robots with cameras': (robots('robot'), DRAWN)}
ROWS = [*((reader, name, values) for reader, pixels in READERS.values()
          for name, values in ((WIDTH, pixels), (HEIGHT, pixels), (RATE, RATES))),
        (view, WIDTH, DRAWN), (view, HEIGHT, DRAWN), (replay, RATE, RATES)]
NAMES = ['{}: {}'.format(who, name) for who in READERS for name in (WIDTH, HEIGHT, RATE)]
NAMES += ['view: ' + WIDTH, 'view: ' + HEIGHT, 'replay: ' + RATE]


@pytest.mark.parametrize('read, name, values', ROWS, ids=NAMES)
def test_each_reader_has_the_range(read, name, values, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(selection, 'DEFAULT_DEVICE', '/no/device')
    monkeypatch.chdir(tmp_path)
    low, high, below, above = values
    for value in (low, high):
        read(name, value, tmp_path)
    for value in (below, above):
        with pytest.raises((UserError, SystemExit, argparse.ArgumentTypeError)) as refused:
            read(name, value, tmp_path)
        text = str(refused.value) + capsys.readouterr().err
        assert 'from {:g} to {:g}'.format(low, high) in text
        assert repr(value) in text or repr(float(value)) in text
        assert refused.type is SystemExit or '_'.join(name.split('_')[1:]) in text


def launch_file(name):
    return ElementTree.parse(os.path.join(ROOT, 'launch', name + '.launch'))


def test_one_robot_has_the_camera_of_several():
    names = WIDTH, HEIGHT, RATE, 'robot_camera_frame', 'camera_frame_id'
    arguments = types.SimpleNamespace(**{name: '$(arg {})'.format(name) for name in names})
    node = types.SimpleNamespace(_settings=arguments)
    robot = types.SimpleNamespace(
        nodes=types.SimpleNamespace(camera='robot', **vars(arguments)), simulation={})
    group, = (each for each in launch_file('simulator').iter('group')
              if each.get('ns') == 'gazebo')
    assert RobotsNode._parameters_of(node, robot) == {
        each.get('name'): each.get('value') for each in group}


@pytest.mark.parametrize('name', ['camera', 'demo', 'robot', 'robots', 'simulator'])
def test_launch_files_have_the_defaults_of_the_code(name):
    expected = {WIDTH: UsbCamSettings.image_width, HEIGHT: UsbCamSettings.image_height,
                RATE: UsbCamSettings.framerate, 'camera_frame_id': UsbCamSettings.camera_frame_id,
                'robot_camera_frame': ManagerSettings.robot_camera_frame,
                'pixel_format': UsbCamSettings.pixel_format}
    given = {each.get('name'): each.get('default') for each in launch_file(name).iter('arg')
             if each.get('name') in expected and each.get('default') is not None}
    assert given
    for argument, value in given.items():
        assert type(expected[argument])(value) == expected[argument]
