"""The log of controls that have no effect."""
from types import SimpleNamespace

import pytest

from img_recog.camera.usb_cam_settings import ControlSettings
from img_recog.nodes.usb_cam import usb_cam_node
from img_recog.nodes.usb_cam.usb_cam_node import CameraControls


@pytest.fixture
def lines(monkeypatch):
    logged = []
    monkeypatch.setattr(usb_cam_node, 'rospy', SimpleNamespace(
        loginfo=lambda text, *values: logged.append(text % values),
        logwarn=lambda text, *values: logged.append(text % values)))
    return logged


@pytest.mark.parametrize('settings, intrinsic, device, logged', [
    (ControlSettings(brightness=5, autoexposure=False), {'zoom': 3}, None,
     ['not a device: these controls have no effect: brightness, autoexposure, zoom']),
    (ControlSettings(), {}, None, []),
    (ControlSettings(brightness=5), {}, '/no/such/device',
     ['cannot set the controls of /no/such/device: No such file or directory'])])
def test_controls_without_effect_are_logged_once(lines, settings, intrinsic, device, logged):
    controls = CameraControls(settings, intrinsic)
    for _ in range(2):
        controls.set_device(device)
    assert lines == logged
