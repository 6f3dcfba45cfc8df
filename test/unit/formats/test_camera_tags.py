"""The cameras in <gazebo> tags."""
import math

import pytest

from img_recog.simulation.simulation_settings import CameraSettings
from img_recog_helpers.parsed import cameras, tags
from img_recog_helpers.refusals import refusal

# like that of the waffle_pi of turtlebot3_description
PI = '''<gazebo reference="camera_rgb_frame"><sensor type="camera" name="Pi Camera">
<camera><horizontal_fov>1.085595</horizontal_fov>
<image><width>640</width><height>480</height><format>R8G8B8</format></image>
<clip><near>0.03</near><far>100</far></clip></camera>
<plugin name="camera_controller" filename="libgazebo_ros_camera.so">
<alwaysOn>true</alwaysOn><updateRate>30.0</updateRate><cameraName>camera</cameraName>
<frameName>camera_rgb_optical_frame</frameName><imageTopicName>rgb/image_raw</imageTopicName>
<cameraInfoTopicName>rgb/camera_info</cameraInfoTopicName></plugin></sensor></gazebo>'''
DEPTH = PI.replace('"camera" name="Pi Camera"', '"depth" name="realsense_R200"').replace(
    'ros_camera', 'ros_openni_kinect').replace('640', '1920')
PLAIN = '''<gazebo reference="front"><sensor type="camera" name="c">{}
<plugin name="p" filename="libgazebo_ros_camera.so">{}</plugin></sensor></gazebo>'''

OF_SDF = {'camera_width': 320, 'camera_height': 240, 'camera_horizontal_fov': 1.047,
          'camera_near': 0.1, 'camera_far': 100.0}       # its defaults


def robot(*inside):
    return ('<robot name="r"><link name="front"/><link name="camera_rgb_frame"/>{}</robot>'
            .format(''.join(inside)))


def read(*inside):
    return list(cameras(robot(*inside)).cameras)


def test_the_camera_of_the_waffle_pi():
    assert read(PI) == [CameraSettings(
        camera_frame='camera_rgb_frame', camera_optical_frame='camera_rgb_optical_frame',
        camera_width=640, camera_height=480, camera_horizontal_fov=1.085595, camera_near=0.03,
        camera_far=100.0, camera_rate=30.0, camera_image_topic='camera/rgb/image_raw',
        camera_info_topic='camera/rgb/camera_info')]
    assert tags(robot(PI), kinds=()) == ({}, [], [])


def test_what_is_not_given_is_that_of_the_plugin():
    camera, = read(PLAIN.format('', ''))
    assert camera == CameraSettings(
        camera_frame='front', camera_optical_frame='camera_rgb_optical_frame',
        camera_image_topic='image_raw', camera_info_topic='camera_info', **OF_SDF)
    depth, = read(PLAIN.replace('type="camera"', 'type="depth"').replace(
        'libgazebo_ros_camera', 'libgazebo_ros_openni_kinect').format(
            '', '<cameraName>eye</cameraName>'))
    assert (depth.camera_image_topic, depth.camera_info_topic, depth.camera_depth_topic,
            depth.camera_depth_info_topic) == (
                'eye/ir/image_raw', 'eye/ir/camera_info', 'eye/depth/image_raw',
                'eye/depth/camera_info')


@pytest.mark.parametrize('sensor, plugin, label', [
    ('', '<distortionK1>0.00000001</distortionK1><distortionT2>-0.10</distortionT2>',
     'distortion by the plugin'),
    ('<camera><lens><intrinsics><fx>9</fx></intrinsics></lens></camera>', '', 'lens intrinsics'),
    ('', '<reflectanceTopicName>shine</reflectanceTopicName>', 'reflectance')])
def test_what_is_not_simulated_of_a_camera_is_named(sensor, plugin, label):
    found = cameras(robot(PLAIN.format(sensor, plugin)))
    assert found.not_simulated == (label + ' of sensor c',) and len(found.cameras) == 1


def test_another_plugin_in_a_camera_is_named():
    text = robot(PLAIN.format('<plugin name="o" filename="libother.so"/>', ''))
    assert tags(text).not_simulated == ['plugin libother.so']


def test_several_cameras_in_their_order():
    names = [camera.camera_frame for camera in read(PI, PLAIN.format('', ''), DEPTH.replace(
        '>camera<', '>eye<'))]
    assert names == ['camera_rgb_frame', 'front', 'camera_rgb_frame']


def test_of_two_cameras_with_one_topic_the_first_counts():
    found = cameras(robot(PI, DEPTH))
    assert [camera.camera_width for camera in found.cameras] == [640]
    assert found.not_simulated == (
        'sensor realsense_R200, because its topic camera/rgb/image_raw is one of sensor Pi '
        'Camera',)


@pytest.mark.parametrize('tag, label', [
    ('<gazebo reference="front"><sensor type="camera" name="c"/></gazebo>', 'sensor camera'),
    (PLAIN.format('', '').replace('libgazebo_ros_camera', 'libother'), 'sensor camera'),
    (PLAIN.format('', '').replace('type="camera"', 'type="thermal"'), 'sensor thermal')])
def test_other_sensors_are_no_cameras(tag, label):
    assert read(tag) == [] and label in tags(robot(tag)).not_simulated


@pytest.mark.parametrize('sensor, plugin, words', [
    ('<camera><horizontal_fov>0</horizontal_fov></camera>', '',
     'sensor c: camera_horizontal_fov: got 0.0, allowed is'),
    ('<camera><horizontal_fov>{}</horizontal_fov></camera>'.format(math.pi), '',
     'sensor c: camera_horizontal_fov: got 3.141592653589793, allowed is at most'),
    ('<camera><image><width>10000</width></image></camera>', '',
     'sensor c: camera_width: got 10000, allowed is'),
    ('<camera><image><width>wide</width></image></camera>', '',
     "<image/width> of sensor c: got 'wide', expected a whole number"),
    ('<camera><clip><near>x</near></clip></camera>', '', "<clip/near> of sensor c: got 'x'"),
    ('<pose>1 2</pose>', '', "<pose> of sensor c: got '1 2', expected 6 finite numbers"),
    ('', '<updateRate>fast</updateRate>', "<updateRate> of sensor c: got 'fast'"),
    ('', '<updateRate>-1</updateRate>', 'sensor c: camera_rate: got -1.0, allowed is'),
    ('<update_rate>nan</update_rate>', '', "<update_rate> of sensor c: got 'nan'"),
    ('<camera><image><width>0</width></image></camera>', '', 'sensor c: camera_width: got 0'),
    ('<camera><image><width>1234567890</width></image></camera>', '',
     "<image/width> of sensor c: got '1234567890', expected a whole number"),
    ('<camera><clip><near>nan</near></clip></camera>', '', "<clip/near> of sensor c: got 'nan'"),
    ('<camera><clip><far>1e300</far></clip></camera>', '', 'sensor c: camera_far: got 1e+300'),
    ('<camera><clip><near>2</near><far>2</far></clip></camera>', '',
     'sensor c: camera_near: got 2.0, allowed is less than camera_far, which is 2.0'),
    ('<camera><noise><stddev>-0.1</stddev></noise></camera>', '',
     'sensor c: camera_noise: got -0.1, allowed is'),
    ('<pose>1e300 0 0 0 0 0</pose>', '', 'sensor c: camera_x: got 1e+300')])
def test_wrong_values_are_refused(sensor, plugin, words):
    assert words in refusal(read, PLAIN.format(sensor, plugin))


def test_a_camera_without_a_link_is_named():
    found = cameras(robot(PLAIN.format('', '').replace(' reference="front"', '')))
    assert found == ((), ('sensor c, because its <gazebo> tag has no reference',))


def test_the_first_camera_of_a_sensor_counts_and_others_in_the_tag_are_passed_over():
    inside = ('<camera><image><width>{}</width></image></camera>'
              '<camera><image><width>99</width></image></camera>')
    one, other = (PLAIN.format(inside.format(width), '<cameraName>{}</cameraName>'.format(width))
                  for width in (32, 64))
    lost = PLAIN.replace(' reference="front"', '').format('', '')
    joined = one.replace('</gazebo>', other.split('>', 1)[1]).replace('<sensor', (
        '<sensor type="camera" name="d"/><sensor'), 1)
    found = cameras(robot(lost, joined))
    assert [camera.camera_width for camera in found.cameras] == [32, 64]
    assert found.not_simulated == (
        'sensor camera', 'sensor c, because its <gazebo> tag has no reference')


@pytest.mark.parametrize('tag, default', [
    ('imageTopicName', 'ir/image_raw'), ('cameraInfoTopicName', 'ir/camera_info'),
    ('depthImageTopicName', 'depth/image_raw'),
    ('depthImageCameraInfoTopicName', 'depth/camera_info'), ('pointCloudTopicName', 'points')])
def test_each_topic_of_two_cameras_can_be_the_same(tag, default):
    kinect = PLAIN.replace('type="camera"', 'type="depth"').replace(
        'libgazebo_ros_camera', 'libgazebo_ros_openni_kinect')
    second = kinect.replace('name="c"', 'name="d"').format('', (
        '<cameraName>b</cameraName><{0}>/a/{1}</{0}>').format(tag, default))
    found = cameras(robot(kinect.format('', '<cameraName>a</cameraName>'), second))
    assert len(found.cameras) == 1 and found.not_simulated == (
        'sensor d, because its topic a/{} is one of sensor c'.format(default),)
