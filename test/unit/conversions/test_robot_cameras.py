"""What the camera info of a camera on a robot says, and depths as images and clouds of points."""
import math

import numpy as np
import pytest
from std_msgs.msg import Header

from img_recog.conversions import robot_cameras
from img_recog.conversions.robot_cameras import DrawnCamera
from img_recog.model import BOX, Shape
from img_recog.rendering import lens_views
from img_recog.rendering.camera import Camera
from img_recog.rendering.lens_views import slopes
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog_helpers.drawn import GREEN, HERE, at, loaded, scene, visual

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


@pytest.mark.parametrize('limits, wanted', [
    ((0.0, 10000.0), [0.25, 3.25, np.nan]), ((0.4, 5.0), [np.nan, 3.25, np.nan]),
    ((0.0, 3.0), [0.25, np.nan, np.nan])])
def test_floats_are_not_a_number_for_nothing_and_beyond_the_limits(limits, wanted):
    depths = robot_cameras.within(np.array([[0.25, 3.25, np.inf]], np.float32), limits)
    found = robot_cameras.depths_to_bytes(depths, '32FC1').view(np.float32)[0, :, 0]
    assert np.array_equal(found, np.array(wanted, np.float32), equal_nan=True)


def test_millimeters():
    depths = np.array([[0.0014, 1.2346, 65.535, 65.6, np.nan]], np.float32)
    encoded = robot_cameras.depths_to_bytes(depths, '16UC1')
    assert encoded.shape == (1, 5, 2) and encoded.dtype == np.uint8
    assert encoded.view(np.uint16)[0, :, 0].tolist() == [1, 1235, 65535, 0, 0]


def cloud(limits):
    """Return the cloud of a wall 2 m ahead of a camera, 1 m wide, in front of nothing."""
    camera = Camera(64, 48, 1.2)
    renderer = loaded(scene(visual(Shape(BOX, (0.2, 1.0, 9.0)), at(2.1, 0, 0), GREEN)), HERE)
    image, depth = (draw(renderer, camera, np.eye(4), HERE)
                    for draw in (lens_views.draw, lens_views.depth))
    return to_msg(robot_cameras.within(depth, limits), image, camera)


def to_msg(depths, image, camera):
    """Return the message of a cloud."""
    msg = robot_cameras.cloud_without_points(depths, Header(frame_id='lens'))
    data = np.full((*depths.shape, robot_cameras.POINT_BYTES), 7, np.uint8)
    robot_cameras.draw_points(data, depths, image, slopes(camera))
    assert not data[..., 12:16].any() and not data[..., 19:].any()      # not used
    msg.data = data.tobytes()
    return msg


def test_points_are_on_the_plane_of_a_wall():
    msg = cloud((0.4, 5.0))
    points, colors = robot_cameras.points_from_msg(msg)
    assert (msg.height, msg.width, msg.point_step, msg.row_step) == (48, 64, 32, 64 * 32)
    assert [(field.name, field.offset) for field in msg.fields] == [
        ('x', 0), ('y', 4), ('z', 8), ('rgb', 16)]
    assert not msg.is_dense and msg.header.frame_id == 'lens'
    on_wall = np.isfinite(points[..., 2])
    assert np.allclose(points[on_wall][:, 2], 2.0, atol=1e-4)
    assert (points[on_wall][:, 0].min(), points[on_wall][:, 0].max()) == pytest.approx(
        (-0.5, 0.5), abs=0.045)
    assert points[0, 32, 1] < -0.9 and points[47, 32, 1] > 0.9      # y is downward
    assert colors[24, 32].tolist() == pytest.approx([0, 180, 0], abs=12)
    assert np.isnan(points[24, 2]).all()


@pytest.mark.parametrize('limits', [(2.5, 5.0), (0.4, 1.9)])
def test_beyond_the_limits_there_are_no_points(limits):
    points, _ = robot_cameras.points_from_msg(cloud(limits))
    assert np.isnan(points).all()


def test_a_cloud_without_gaps_is_dense():
    depths = np.full((2, 3), 1.5, np.float32)
    msg = to_msg(depths, np.zeros((2, 3, 3), np.uint8), Camera(3, 2, 1.0))
    assert msg.is_dense
