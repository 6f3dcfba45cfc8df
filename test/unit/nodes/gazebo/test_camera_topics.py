"""The topics of a camera on the simulated robot."""
import math

import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo

from img_recog.conversions import robot_cameras
from img_recog.nodes.gazebo.camera_topics import CameraTopics, optical_transform
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.simulation.sensors.robot_camera import Exposure
from img_recog.simulation.simulation_settings import CameraSettings

SETTINGS = CameraSettings(camera_frame='camera_link', camera_width=32, camera_height=24,
                          camera_horizontal_fov=1.0, camera_optical_frame='lens',
                          camera_image_topic='eye/image_raw', camera_info_topic='eye/camera_info')
DEPTH = dict(camera_depth_topic='eye/depth', camera_depth_info_topic='eye/depth_info')


def settings(**more):
    return CameraSettings(**{**vars(SETTINGS), **more})


def exposure(x=0.0):
    pose = np.eye(4)
    pose[0, 3] = x
    return Exposure(pose, np.full((2, 7), x))


def picture(depth=False):
    return (np.full((24, 32, 3), 7, np.uint8),
            np.full((24, 32), 1.5, np.float32) if depth else None)


def test_an_image_and_its_info_have_one_header(publishers):
    topics = CameraTopics(SETTINGS)
    assert set(publishers) == {'eye/image_raw', 'eye/image_raw/compressed', 'eye/camera_info'}
    shot = topics.shot(exposure(5.0))
    assert (shot.camera.width, shot.camera.height, shot.camera.horizontal_fov) == (32, 24, 1.0)
    assert shot.pose[0, 3] == 5.0 and shot.depth is False
    topics.publish(picture(), 1.25)
    (image, encoding, header), = publishers['eye/image_raw'].sent
    (info,), = publishers['eye/camera_info'].sent
    assert image.shape == (24, 32, 3) and encoding == 'rgb8' and np.all(image == 7)
    assert (header.frame_id, header.stamp.to_sec()) == ('lens', 1.25)
    assert info.header is header


def test_an_image_that_is_drawn_when_the_camera_is_removed_is_dropped(publishers):
    topics = CameraTopics(SETTINGS)
    topics.close()
    topics.publish(picture(), 1.0)
    assert all(each.is_ended and not each.sent for each in publishers.values())


def test_the_info_is_that_of_a_pinhole_camera(publishers):
    info = CameraTopics(SETTINGS).info(None)
    assert isinstance(info, CameraInfo) and (info.width, info.height) == (32, 24)
    focal = 16 / math.tan(0.5)
    assert info.K == pytest.approx([focal, 0, 15.5, 0, focal, 11.5, 0, 0, 1])
    assert info.P == pytest.approx([focal, 0, 15.5, 0, 0, focal, 11.5, 0, 0, 0, 1, 0])
    assert info.R == [1, 0, 0, 0, 1, 0, 0, 0, 1]
    assert (info.distortion_model, info.D) == ('plumb_bob', [0.0] * 5)


def test_images_are_copied_for_the_compression_only_if_somebody_wants_it(publishers):
    topics, drawn = CameraTopics(SETTINGS), picture()
    topics.publish(drawn, 1.0)
    assert publishers['eye/image_raw/compressed'].sent == []
    publishers['eye/image_raw/compressed'].subscribers = 1
    topics.publish(drawn, 2.0)
    (copy, encoding, header), = publishers['eye/image_raw/compressed'].sent
    drawn[0][:] = 0          # as when the next one is drawn
    assert np.all(copy == 7) and encoding == 'rgb8' and header.stamp.to_sec() == 2.0


@pytest.mark.parametrize('topic', ['eye/image_raw', 'eye/camera_info', 'eye/depth',
                                   'eye/image_raw/compressed', 'eye/depth_info'])
def test_a_subscriber_of_any_topic_wants_images(publishers, topic):
    topics = CameraTopics(settings(**DEPTH))
    assert not topics.is_wanted()
    publishers[topic].subscribers = 1
    assert topics.is_wanted()
    assert topics.shot(exposure()).depth is (topic == 'eye/depth')


def test_depths_are_published_as_floats(publishers):
    topics = CameraTopics(settings(**DEPTH))
    topics.publish(picture(depth=True), 2.0)
    (image, encoding, header), = publishers['eye/depth'].sent
    assert encoding == '32FC1' and image.shape == (24, 32, 4) and image.dtype == np.uint8
    assert np.all(image.copy().view(np.float32) == 1.5)
    assert publishers['eye/depth_info'].sent[0][0].header is header
    nearer = CameraTopics(settings(**DEPTH, camera_points_max=1.0))
    nearer.publish(picture(depth=True), 2.0)
    assert np.isnan(publishers['eye/depth'].sent[-1][0].copy().view(np.float32)).all()


@pytest.mark.parametrize('encoding, pixel', [('rgb8', [10, 200, 40]), ('bgr8', [40, 200, 10]),
                                             ('mono8', 125)])
def test_images_have_the_encoding_of_the_settings(publishers, encoding, pixel):
    topics = CameraTopics(settings(camera_encoding=encoding))
    publishers['eye/image_raw/compressed'].subscribers = 1
    topics.publish((np.full((24, 32, 3), (10, 200, 40), np.uint8), None), 1.0)
    for topic in ('eye/image_raw', 'eye/image_raw/compressed'):
        (image, name, _), = publishers[topic].sent
        assert name == encoding and image[3, 4].tolist() == pixel


def test_points_and_millimeters_of_a_depth_camera(publishers):
    topics = CameraTopics(settings(camera_points_topic='eye/points',
                                   camera_depth_encoding='16UC1', **DEPTH))
    assert not topics.shot(exposure()).depth
    topics.publish(picture(depth=True), 1.0)
    assert publishers['eye/points'].sent == []      # nobody has subscribed
    publishers['eye/points'].subscribers = 1
    assert topics.is_wanted() and topics.shot(exposure()).depth
    topics.publish(picture(depth=True), 2.0)
    (cloud,), = publishers['eye/points'].sent
    points, colors = robot_cameras.points_from_msg(cloud)
    assert np.isnan(points[..., 2]).sum() == 0 and np.all(points[..., 2] == 1.5)
    assert np.all(colors == 7)
    (image, encoding, header) = publishers['eye/depth'].sent[-1]
    assert encoding == '16UC1' and np.all(image.copy().view(np.uint16) == 1500)
    assert cloud.header is header


def test_a_lens_without_a_model_is_a_warning(publishers, caplog):
    topics = CameraTopics(settings(camera_lens='custom', camera_c3=0.3))
    assert 'the camera info on eye/camera_info has no calibration' in caplog.text
    assert topics.info(None).K == [0.0] * 9


def test_noise_is_that_of_the_camera_and_of_the_time(publishers):
    for topic in ('left', 'right'):
        topics = CameraTopics(settings(camera_noise=0.1, camera_image_topic=topic))
        for time_s in (1.0, 2.0, 1.0):
            topics.publish(picture(), time_s)
    first, second, again = (values[0] for values in publishers['left'].sent)
    assert first.std() > 5 and np.array_equal(first, again) and not np.array_equal(first, second)
    assert not np.array_equal(first, publishers['right'].sent[0][0])


def test_the_optical_frame_of_a_camera_that_looks_ahead():
    transform = optical_transform(settings(camera_x=0.1, camera_z=0.2))
    assert (transform.header.frame_id, transform.child_frame_id) == ('camera_link', 'lens')
    place, turn = transform.transform.translation, transform.transform.rotation
    assert (place.x, place.y, place.z) == pytest.approx((0.1, 0, 0.2))
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx((-0.5, 0.5, -0.5, 0.5))


def test_in_lockstep_what_was_used_once_stays_in_use(publishers):
    topics = CameraTopics(settings(**DEPTH), Redelivery())
    assert not topics.is_wanted() and not topics.shot(exposure()).depth
    publishers['eye/depth'].subscribers = 1
    assert topics.is_wanted() and topics.shot(exposure()).depth
    publishers['eye/depth'].subscribers = 0
    assert topics.is_wanted() and topics.shot(exposure()).depth
