"""Depths as images and as clouds of points."""
import numpy as np
import pytest
from std_msgs.msg import Header

from img_recog.conversions import depth_msgs
from img_recog.model import BOX, Shape
from img_recog.rendering import lens_views
from img_recog.rendering.camera import Camera
from img_recog.rendering.rays import slopes
from img_recog_helpers.drawn import GREEN, HERE, at, loaded, scene, visual


@pytest.mark.parametrize('limits, wanted', [
    ((0.0, 10000.0), [0.25, 3.25, np.nan]), ((0.4, 5.0), [np.nan, 3.25, np.nan]),
    ((0.0, 3.0), [0.25, np.nan, np.nan])])
def test_floats_are_not_a_number_for_nothing_and_beyond_the_limits(limits, wanted):
    depths = depth_msgs.within(np.array([[0.25, 3.25, np.inf]], np.float32), limits)
    found = depth_msgs.to_bytes(depths, '32FC1').view(np.float32)[0, :, 0]
    assert np.array_equal(found, np.array(wanted, np.float32), equal_nan=True)


def test_millimeters():
    depths = np.array([[0.0014, 1.2346, 65.535, 65.6, np.nan]], np.float32)
    encoded = depth_msgs.to_bytes(depths, '16UC1')
    assert encoded.shape == (1, 5, 2) and encoded.dtype == np.uint8
    assert encoded.view(np.uint16)[0, :, 0].tolist() == [1, 1235, 65535, 0, 0]


def cloud(limits):
    """Return the cloud of a wall 2 m ahead of a camera, 1 m wide, in front of nothing."""
    camera = Camera(64, 48, 1.2)
    renderer = loaded(scene(visual(Shape(BOX, (0.2, 1.0, 9.0)), at(2.1, 0, 0), GREEN)), HERE)
    image, depth = (draw(renderer, camera, np.eye(4), HERE)
                    for draw in (lens_views.draw, lens_views.depth))
    return to_msg(depth_msgs.within(depth, limits), image, camera)


def to_msg(depths, image, camera):
    """Return the message of a cloud."""
    msg = depth_msgs.cloud_without_points(depths, Header(frame_id='lens'))
    data = np.full((*depths.shape, depth_msgs.POINT_BYTES), 7, np.uint8)
    depth_msgs.draw_points(data, depths, image, slopes(camera))
    assert not data[..., 12:16].any() and not data[..., 19:].any()      # not used
    msg.data = data.tobytes()
    return msg


def test_points_are_on_the_plane_of_a_wall():
    msg = cloud((0.4, 5.0))
    points, colors = depth_msgs.from_msg(msg)
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
    points, _ = depth_msgs.from_msg(cloud(limits))
    assert np.isnan(points).all()


def test_a_cloud_without_gaps_is_dense():
    depths = np.full((2, 3), 1.5, np.float32)
    msg = to_msg(depths, np.zeros((2, 3, 3), np.uint8), Camera(3, 2, 1.0))
    assert msg.is_dense
