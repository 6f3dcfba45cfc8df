"""Topics that two robots would share, or that are not those of a robot."""
import dataclasses

import pytest

from img_recog.conversions.topic_checks import check_topics
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.simulation_settings import CameraSettings, DriveSettings, Names
from img_recog_helpers import robots
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger, read

CAMERA = CameraSettings(camera_frame='base_link', camera_image_topic='eye/image',
                        camera_info_topic='eye/info')
PLAIN = read(burger())
SPEC = PLAIN.with_sensor(robots.CAMERA, CAMERA)


DEPTH = dict(camera_depth_topic='eye/depth', camera_depth_info_topic='eye/depth_info')


def resolved(name):
    return '/' + name.lstrip('/')


def with_camera(**more):
    """Return the robot with a second camera."""
    return SPEC.with_sensor(robots.CAMERA, dataclasses.replace(
        CAMERA, **{'camera_frame': 'rear', 'camera_image_topic': 'a', **more}))


def test_a_robot_may_have_the_topics_of_another_in_its_namespace():
    check_topics(SPEC, [SPEC._replace(names=Names('robot2', 'robot2'))], resolved)
    check_topics(with_camera(camera_info_topic='b', **DEPTH), [], resolved)


@pytest.mark.parametrize('spec, others, words', [
    (SPEC, [SPEC], 'the topic eye/image is camera_image_topic of the camera'),
    (PLAIN, [SPEC], 'two sensors are on the topic'),
    (PLAIN.with_sensor(robots.CAMERA, CameraSettings(
        camera_frame='base_link', camera_image_topic='scan', camera_info_topic='a')), [],
     'two sensors are on the topic'),
    *((SPEC.changed(drive=DriveSettings(command_topic=topic)), [],
       'the topic {} is not that of a robot'.format(topic)) for topic in ('/clock', '/tf')),
    *((SPEC.changed(sensors={**SPEC.settings.sensors, 'odometry': OdometrySettings(
        odometry_topic=topic)}), [], 'the topic {} is not that of a robot'.format(topic))
      for topic in ('/tf', '/rosout')),
    (SPEC.changed(drive=DriveSettings(command_topic='scan')), [],
     'a sensor and commands are on the topic'),
    (PLAIN.with_sensor(robots.CAMERA, CameraSettings(camera_image_topic='not a name')), [],
     "camera_image_topic: got 'not a name', allowed is a valid topic name"),
    *((PLAIN.changed(drive=DriveSettings(command_topic=topic)), [],
       'command_topic: got {!r}, allowed is a valid topic name'.format(topic))
      for topic in ('a b', '1/a', 'eye//!', 'é')),
    (with_camera(), [],
     'the topic eye/info is camera_info_topic of the camera on base_link and camera_info_topic of '
     'the camera on rear; give each camera other topics: in a <gazebo> tag, another <cameraName>; '
     'as parameters, another camera_info_topic'),
    (with_camera(camera_image_topic='/eye/image', camera_info_topic='b'), [],
     'the topic /eye/image is camera_image_topic of the camera on base_link and'),
    (with_camera(camera_info_topic='b', **{**DEPTH, 'camera_depth_topic': 'a'}), [],
     'the topic a is camera_image_topic of the camera on rear and camera_depth_topic')])
def test_a_topic_that_is_taken_is_refused(spec, others, words):
    assert words in refusal(check_topics, spec, others, resolved)
