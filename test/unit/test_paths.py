"""Calibration URLs."""
import os

import pytest

from img_recog.nodes import camera_info_urls
from img_recog.settings import SettingError


def test_calibration_urls(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    default = str(tmp_path / 'camera_info' / 'front.yaml')
    assert camera_info_urls.path_of('', 'front') == default
    assert camera_info_urls.path_of('file://${ROS_HOME}/camera_info/${NAME}.yaml',
                                    'front') == default
    assert camera_info_urls.path_of('file:///a/b.yaml', 'front') == '/a/b.yaml'
    package = camera_info_urls.path_of('package://sensor_msgs/c/d.yaml', 'front')
    assert package.endswith('sensor_msgs/c/d.yaml') and os.path.isabs(package)


@pytest.mark.parametrize('url, words', [
    ('http://x/y', "got 'http://x/y', allowed is file:///PATH"),
    ('file://relative', "got 'file://relative'"),
    ('package://no_such_package/a.yaml', 'there is no package no_such_package')])
def test_calibration_urls_that_are_refused(url, words):
    with pytest.raises(SettingError) as error:
        camera_info_urls.path_of(url, 'front')
    assert words in str(error.value)
