"""What the camera info of a camera on a robot says."""
import math

import pytest

from img_recog.conversions.robot_cameras import DrawnCamera
from img_recog.rendering.camera import Camera
from img_recog.simulation.simulation_settings import CameraSettings

SIZE = dict(camera_width=320, camera_height=240)


def test_a_stereo_pair_says_its_baseline():
    found = DrawnCamera(CameraSettings(camera_horizontal_fov=1.0, camera_baseline=0.07,
                                       **SIZE)).calibration
    focal = 160 / math.tan(0.5)
    assert found.projection == pytest.approx(
        (focal, 0, 159.5, -0.07 * focal, 0, focal, 119.5, 0, 0, 0, 1, 0))
    assert found.rectification == (1, 0, 0, 0, 1, 0, 0, 0, 1)
    assert found.camera_matrix == pytest.approx((focal, 0, 159.5, 0, focal, 119.5, 0, 0, 1))
    assert (found.camera_name, found.width, found.height) == ('', 320, 240)


def test_a_fisheye():
    settings = CameraSettings(camera_lens='equidistant', camera_horizontal_fov=math.pi, **SIZE)
    camera = DrawnCamera(settings)
    found = camera.calibration
    assert (found.distortion_model, found.distortion) == ('equidistant', (0.0,) * 4)
    focal = 320 / math.pi
    assert found.camera_matrix == pytest.approx((focal, 0, 159.5, 0, focal, 119.5, 0, 0, 1))
    assert camera.camera == Camera(320, 240, math.pi, 0.03, 100.0, settings.lens)


def test_distortion():
    found = DrawnCamera(CameraSettings(camera_k1=-0.1, camera_p2=0.02, camera_k3=0.3,
                                       **SIZE)).calibration
    assert found.distortion_model == 'plumb_bob'
    assert found.distortion == (-0.1, 0.0, 0.0, 0.02, 0.3)      # k1, k2, p1, p2, k3


def test_a_lens_without_a_model_is_not_calibrated():
    assert DrawnCamera(CameraSettings(
        camera_lens='custom', camera_c3=0.2, **SIZE)).calibration is None
