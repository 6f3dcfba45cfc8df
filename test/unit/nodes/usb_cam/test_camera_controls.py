"""The log of controls that have no effect."""
from types import SimpleNamespace

import pytest

from img_recog.camera.usb_cam_settings import ControlSettings
from img_recog.nodes.usb_cam import device_controls
from img_recog.nodes.usb_cam.device_controls import CameraControls


@pytest.fixture
def lines(monkeypatch):
    """The lines of the log, with their levels."""
    logged = []
    monkeypatch.setattr(device_controls, 'rospy', SimpleNamespace(
        loginfo=lambda text, *values: logged.append(('info', text % values)),
        logwarn=lambda text, *values: logged.append(('warn', text % values))))
    return logged


@pytest.mark.parametrize('settings, intrinsic, logged', [
    (ControlSettings(brightness=5, autoexposure=False), {'zoom': 3}, [
        ('info', 'not a device: these controls have no effect: brightness, autoexposure, zoom')]),
    (ControlSettings(), {}, [])])
def test_controls_without_effect_are_logged_once(lines, settings, intrinsic, logged):
    controls = CameraControls(settings, intrinsic)
    for _ in range(2):
        controls.set_device(None)
    assert lines == logged


def test_controls_of_a_device_are_not_logged(lines, tmp_path):
    controls = CameraControls(ControlSettings(brightness=5), {})
    controls.set_device(str(tmp_path / 'gone'))
    assert [level for level, _ in lines] == ['warn']
