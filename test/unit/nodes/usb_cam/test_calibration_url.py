"""Calibration URLs."""
import os

import pytest

from img_recog.nodes.usb_cam import calibration
from img_recog.settings import SettingError


def test_calibration_urls(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    default = str(tmp_path / 'camera_info' / 'front.yaml')
    assert calibration.path_of_url('', 'front') == default
    assert calibration.path_of_url(
        'file://${ROS_HOME}/camera_info/${NAME}.yaml', 'front') == default
    assert calibration.path_of_url('file:///a/b.yaml', 'front') == '/a/b.yaml'
    package = calibration.path_of_url('package://sensor_msgs/c/d.yaml', 'front')
    assert calibration.path_of_url('package://sensor_msgs/x/../c/d.yaml', 'front') == package
    assert package.endswith('sensor_msgs/c/d.yaml') and os.path.isabs(package)


@pytest.mark.parametrize('url, words', [
    ('http://x/y', "got 'http://x/y', allowed is file:///PATH"),
    ('file://relative', "got 'file://relative'"),
    ('package://sensor_msgs/../a.yaml', 'the path leaves the package sensor_msgs'),
    ('package://sensor_msgs/a/../../sensor_msgs2/a.yaml', 'the path leaves the package'),
    ('package://sensor_msgs//etc/a.yaml', 'the path leaves the package'),
    ('package://sensor_msgs/', 'the path leaves the package'),
    ('package:///etc/a.yaml', 'there is no package '),
    ('package://../etc/a.yaml', 'there is no package ..'),
    ('package://no_such_package/a.yaml', 'there is no package no_such_package')])
def test_calibration_urls_that_are_refused(url, words):
    with pytest.raises(SettingError) as error:
        calibration.path_of_url(url, 'front')
    assert words in str(error.value)
