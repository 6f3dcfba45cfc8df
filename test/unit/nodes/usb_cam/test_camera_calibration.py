"""The calibration that the node publishes and stores, with a fake log and fake parameters."""
import os
from types import SimpleNamespace

import pytest
from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfoRequest
from std_msgs.msg import Header

from img_recog.camera import calibration
from img_recog.camera.calibration import Calibration
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.nodes.usb_cam import camera_info
from img_recog.ros import parameters
from img_recog_helpers.refusals import refusal

GIVEN = {
    'width': 640, 'height': 480, 'distortion_model': 'plumb_bob', 'D': [0.1] * 5,
    'K': [500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0],
    'R': [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    'P': [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]}


class FakeRos:
    """Records the lines of the log, and the services by their names."""

    def __init__(self):
        self.lines, self.services = [], {}
        for level in ('info', 'warn', 'err'):
            setattr(self, 'log' + level, self._logger(level))

    def _logger(self, level):
        return lambda text, *values: self.lines.append((level, text % values))

    def Service(self, name, _, handler):        # noqa: N802
        self.services[name] = handler


@pytest.fixture
def ros(monkeypatch):
    fake = FakeRos()
    monkeypatch.setattr(camera_info, 'rospy', fake)
    return fake


@pytest.fixture
def make(ros, tmp_path, monkeypatch):
    """A function that makes the calibration of a camera; its file is calibration.yaml."""
    def make_calibration(url='file://{}/calibration.yaml'.format(tmp_path), **settings):
        # only get_param is faked, so the error line is the same as for all parameters
        monkeypatch.setattr(parameters, 'rospy', SimpleNamespace(
            get_param=lambda *_: {'camera_info_url': url},
            resolve_name=lambda name: name.replace('~', '/usb_cam/')))
        made = camera_info.CameraCalibration(
            UsbCamSettings(camera_info_url=url, **settings))
        made.serve()
        return made
    return make_calibration


@pytest.fixture
def answer(ros):
    """A function that calls the service with the calibration GIVEN, of which fields differ."""
    return lambda **fields: ros.services['~set_camera_info'](
        SetCameraInfoRequest(CameraInfo(**dict(GIVEN, **fields))))


def saved(tmp_path, **fields):
    path = str(tmp_path / 'calibration.yaml')
    values = dict(camera_name='head_camera', width=640, height=480, distortion_model='plumb_bob',
                  distortion=GIVEN['D'], camera_matrix=GIVEN['K'], rectification=GIVEN['R'],
                  projection=GIVEN['P'])
    values.update(fields)
    calibration.save(path, Calibration(**values))
    return path


@pytest.mark.parametrize('fields, is_published, lines', [
    ({}, True, []),
    ({'camera_matrix': [float('nan')] * 9}, False,
     [('err', 'calibration {} has no usable entry camera_matrix (wants finite numbers, has nan); '
              'publishing no calibration')]),
    ({'camera_name': 'narrow_stereo'}, True,
     [('warn', "calibration {} is for camera 'narrow_stereo', but camera_name is head_camera; "
               'using it anyway')])])
def test_the_calibration_of_the_file_is_published_if_it_is_usable(
        make, ros, tmp_path, fields, is_published, lines):
    path = saved(tmp_path, **fields)
    made = make()
    made.set_image_size(640, 480)
    msg = made.to_msg(Header())
    assert (list(msg.K), msg.distortion_model) == (
        (GIVEN['K'], 'plumb_bob') if is_published else ([0.0] * 9, ''))
    assert ros.lines == [(level, line.format(path)) for level, line in lines]


def test_calibration_urls(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    path_of_url, default = camera_info.path_of_url, str(tmp_path / 'camera_info/front.yaml')
    for url, path in (('', default), ('file://${ROS_HOME}/camera_info/${NAME}.yaml', default),
                      ('file:///a/b.yaml', '/a/b.yaml'),
                      ('file://b.yaml', os.path.join(os.environ['PWD'], 'b.yaml'))):
        assert path_of_url(url, 'front') == path
    package = path_of_url('package://sensor_msgs/c/d.yaml', 'front')
    assert path_of_url('package://sensor_msgs/x/../c/d.yaml', 'front') == package
    assert package.endswith('sensor_msgs/c/d.yaml') and os.path.isabs(package)


@pytest.mark.parametrize('url, words', [
    ('http://x/y', 'allowed is file:///PATH, package://PACKAGE/PATH or empty'),
    ('file://', ''),
    ('file:///head_camera.INI', 'allowed is the URL of a YAML file; make one by "rosrun '),
    ('package://sensor_msgs/../a.yaml', 'the path leaves the package sensor_msgs'),
    ('package://sensor_msgs/a/../../sensor_msgs2/a.yaml', 'the path leaves the package'),
    ('package://sensor_msgs//etc/a.yaml', 'the path leaves the package'),
    ('package://sensor_msgs/', 'the path leaves the package'),
    ('package:///etc/a.yaml', 'there is no package '),
    ('package://../etc/a.yaml', 'there is no package ..'),
    ('package://no_such_package/x', 'there is no package no_such_package')])
def test_refused_url_names_the_parameter_with_its_namespace(make, url, words):
    line = refusal(make, url)
    assert line.startswith('parameter /usb_cam/camera_info_url: got {!r}, '.format(url))
    assert words in line


SYNTHETIC = {'video_device': 'synthetic', 'image_width': 320, 'image_height': 240}


# settings, the size of the images if it is known, what is asked for, and the answer
@pytest.mark.parametrize('settings, size, fields, is_good, words', [
    ({}, (640, 480), {'K': [float('nan')] * 9}, False,
     'camera_matrix (wants finite numbers, has nan)'),
    ({}, (640, 480), {'width': 320}, False,
     'the calibration is for 320x480, the images are 640x480'),
    ({}, (640, 480), {}, True, '/calibration.yaml'),
    ({}, None, {'width': 0, 'height': 0}, False, 'image_width'),
    ({}, None, {}, True,
     'its size 640x480 could not be checked: the camera has not been opened yet'),
    # that of the synthetic scene is known before it is open
    (SYNTHETIC, None, {}, False, 'the calibration is for 640x480, the images are 320x240'),
    (SYNTHETIC, None, {'width': 320, 'height': 240}, True, '/calibration.yaml')])
def test_a_calibration_is_written_and_published_if_it_is_good(
        make, answer, ros, tmp_path, settings, size, fields, is_good, words):
    path = saved(tmp_path, distortion=[0.2] * 5)
    made = make(**settings)
    if size:
        made.set_image_size(*size)
    response = answer(**fields)
    assert response.success is is_good and words in response.status_message
    assert [level for level, _ in ros.lines if level == 'err'] == ['err'] * (not is_good)
    kept = calibration.load(path)
    assert kept.distortion == (0.1 if is_good else 0.2,) * 5
    made.set_image_size(320, 240)
    msg = made.to_msg(Header())
    assert tuple(msg.D) == kept.distortion and msg.K[0] == 500 * 320 / kept.width


@pytest.mark.parametrize('name', ['head_camera', '0', '_Front2', 'a-b.c d', '${ROS_HOME}'])
def test_a_calibration_is_written_nowhere_else(make, answer, tmp_path, monkeypatch, name):
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'home'))
    make(url='', camera_name=name)
    answer()
    written = [path for path in tmp_path.rglob('*') if not path.is_dir()]
    assert written == [tmp_path / 'home' / 'camera_info' / (name + '.yaml')]


def test_what_a_killed_node_has_left_is_removed_with_one_line(make, ros, tmp_path):
    left = tmp_path / '.calibration.yaml.0123456789ab.img_recog'
    left.write_text('half')
    make()
    assert not left.exists()
    assert ros.lines[0] == (
        'warn', 'removed what a program that was killed has left: {}'.format(left))
