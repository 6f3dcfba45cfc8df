"""What <sensor> and the plugins of cameras give."""
import math

import pytest

from img_recog.formats import lenses
from img_recog_helpers.parsed import cameras
from img_recog_helpers.refusals import refusal

SENSOR = '''<robot name="r"><link name="front"/><gazebo reference="front">
<sensor type="{}" name="c">{}<plugin name="p" filename="lib{}.so">{}</plugin></sensor></gazebo>
</robot>'''
CAMERA, MULTI = 'gazebo_ros_camera', 'gazebo_ros_multicamera'
KINECT, DEPTH = 'gazebo_ros_openni_kinect', 'gazebo_ros_depth_camera'
# like the lens of the robot for AutoRace of turtlebot3_description
WIDE = '''<camera><horizontal_fov>3.183</horizontal_fov><image><width>320</width>
<height>240</height></image><lens><type>custom</type><custom_function><c1>1.05</c1><c2>4</c2>
<f>1.0</f><fun>tan</fun></custom_function><scale_to_hfov>{}</scale_to_hfov>
<cutoff_angle>3.1415</cutoff_angle><env_texture_size>512</env_texture_size></lens></camera>'''


def read(kind, sensor='', plugin='', library=CAMERA):
    return cameras(SENSOR.format(kind, sensor, library, plugin))


def test_a_custom_lens():
    camera, = read('wideanglecamera', WIDE.format('true')).cameras
    assert camera.camera_horizontal_fov == 3.183
    lens = camera.lens
    assert (lens.divisor, lens.offset, lens.function) == (4.0, 0.0, 'tan')
    assert (lens.cutoff_angle, lens.texture_size) == (3.1415, 512)
    # the edge of the image is at half the field of view
    assert lens.radius(3.183 / 2) == pytest.approx(1)
    inside = '<c3>0.3</c3><f>2</f>'
    unscaled, = read('wideanglecamera', WIDE.format('0').replace('<f>1.0</f>', inside)).cameras
    assert unscaled.lens == (2.1, 4.0, 0.3, 'tan', 3.1415, 512)
    unscaled, = read('wideanglecamera', WIDE.format('0').replace('>tan<', '> sin <')).cameras
    assert unscaled.lens.function == 'sin'
    plain, = read('wideanglecamera', WIDE.format('0').replace('<fun>tan</fun>', '').replace(
        '<c1>1.05</c1>', '')).cameras
    assert (plain.lens.function, plain.lens.scale) == ('tan', 1.0)      # the defaults


@pytest.mark.parametrize('inside, lens', [
    ('<type>equisolid_angle</type><scale_to_hfov>0</scale_to_hfov>', (2.0, 2.0, 0.0, 'sin')),
    ('<type>custom</type><scale_to_hfov> False </scale_to_hfov>', (2.0, 2.0, 0.0, 'tan'))])
def test_a_lens_that_is_not_scaled(inside, lens):
    camera, = read('wideanglecamera', '<camera><lens>{}</lens></camera>'.format(inside)).cameras
    assert camera.lens[:4] == lens


@pytest.mark.parametrize('kind', ['gnomonical', 'stereographic', 'equidistant', 'equisolid_angle',
                                  'orthographic'])
def test_a_lens_of_a_named_type(kind):
    camera, = read('wideanglecamera', '<camera><horizontal_fov>2</horizontal_fov><lens><type>{}'
                   '</type></lens></camera>'.format(kind)).cameras
    plain = lenses.of_type(kind)
    assert camera.lens.radius(1.0) == pytest.approx(1)
    assert camera.lens.radius(0.5) == pytest.approx(plain.radius(0.5) / plain.radius(1.0))
    assert camera.lens.cutoff_angle == math.pi / 2      # the default of SDF


@pytest.mark.parametrize('change, words', [
    (('custom<', 'fisheye<'), "sensor c: camera_lens: got 'fisheye', allowed is one of pinhole,"),
    (('>tan<', '>cot<'), "sensor c: camera_fun: got 'cot', allowed is one of tan, sin, id"),
    (('<c2>4', '<c2>1'), 'sensor c: camera_horizontal_fov: got 3.183, allowed is less, for the'),
    (('<c1>1.05', '<c1>0'), 'sensor c: camera_c1: got 0.0, allowed is'),
    (('>true<', '>yes<'), "<lens/scale_to_hfov> of sensor c: got 'yes', expected true")])
def test_wrong_lenses_are_refused(change, words):
    assert words in refusal(read, 'wideanglecamera', WIDE.format('true').replace(*change))


def test_distortion_of_the_camera():
    given = '<camera><distortion><k1>-0.2</k1><p2>1e-3</p2></distortion></camera>'
    camera, = read('camera', given).cameras
    assert camera.lens == lenses.Distortion(-0.2, 0.0, 0.0, 0.001, 0.0)
    full = '<k1>0.1</k1><k2>0.2</k2><k3>0.3</k3><p1>0.01</p1><p2>0.02</p2>'
    camera, = read('camera', given.replace('<k1>-0.2</k1><p2>1e-3</p2>', full)).cameras
    assert camera.lens == (0.1, 0.2, 0.01, 0.02, 0.3)       # k1, k2, p1, p2, k3
    small = read('wideanglecamera', given.replace('-0.2', '1e-8').replace('1e-3', '-1e-6'))
    assert small.not_simulated == ()
    assert read('camera', given).not_simulated == ()
    assert read('camera').cameras[0].lens is None
    wide = read('wideanglecamera', given)
    assert wide.not_simulated == ('distortion of sensor c',)
    assert isinstance(wide.cameras[0].lens, lenses.Lens)


@pytest.mark.parametrize('given, encoding, problems', [
    ('', 'rgb8', ()), ('<format>R8G8B8</format>', 'rgb8', ()),
    ('<format>L8</format>', 'mono8', ()),
    ('<format>B8G8R8</format>', 'bgr8', ()), ('<format>L_INT8</format>', 'mono8', ()),
    ('<format> RGB_INT8 </format>', 'rgb8', ()), ('<format>BGR_INT8</format>', 'bgr8', ()),
    ('<format>BAYER_RGGB8</format>', 'rgb8', ('format BAYER_RGGB8 of sensor c',))])
def test_the_format_of_images(given, encoding, problems):
    found = read('camera', '<camera><image>{}</image></camera>'.format(given))
    assert found.cameras[0].camera_encoding == encoding and found.not_simulated == problems


EYE = '<cameraName>/eye/</cameraName>'


@pytest.mark.parametrize('kind, sensor, plugin, library, wanted', [
    ('camera', '<camera><horizontal_fov>1.5</horizontal_fov><image><width>32</width><height>24'
     '</height></image><clip><near>0.2</near><far>77</far></clip><noise><mean>0.1</mean><stddev>'
     '0.3</stddev></noise></camera>', '<hackBaseline>0.07</hackBaseline>', CAMERA,
     {'horizontal_fov': 1.5, 'width': 32, 'height': 24, 'near': 0.2, 'far': 77, 'noise': 0.3,
      'noise_mean': 0.1, 'baseline': 0.07}),
    ('camera', '<camera><noise><type>none</type><mean>1</mean><stddev>1</stddev></noise></camera>',
     '', CAMERA, {'noise': 0.0, 'noise_mean': 0.0}),
    # of a size the whole part counts
    ('camera', '<camera><image><width>32.5</width></image></camera>', '', CAMERA, {'width': 32}),
    # the lower one of two rates
    *(('camera', '<update_rate>{}</update_rate>'.format(of_sensor),
       '<updateRate>{}</updateRate>'.format(of_plugin), CAMERA, {'rate': rate})
      for of_plugin, of_sensor, rate in (
          (30, 10, 10.0), (10, 30, 10.0), (0, 20, 20.0), (20, 0, 20.0), (0, 0, 30.0))),
    # a topic with a leading slash is not below the camera
    *(('camera', '', EYE + '<imageTopicName>{}</imageTopicName><frameName>/lens</frameName>'
       .format(given), CAMERA, {'image_topic': topic, 'optical_frame': 'lens'})
      for given, topic in (('raw', 'eye/raw'), ('a/raw', 'eye/a/raw'), ('/raw', 'raw'),
                           ('/a/raw/', 'a/raw'))),
    *(('camera', '', EYE + '<imageTopicName>raw</imageTopicName><robotNamespace>{}'
       '</robotNamespace>'.format(given), CAMERA, {'image_topic': topic})
      for given, topic in (('tb3', 'tb3/eye/raw'), ('/', 'eye/raw'), ('/a/b/', 'a/b/eye/raw'))),
    ('depth', '', EYE + '<depthImageTopicName>d</depthImageTopicName>'
     '<depthImageCameraInfoTopicName>e</depthImageCameraInfoTopicName>', KINECT,
     {'depth_topic': 'eye/d', 'depth_info_topic': 'eye/e'}),
    *(('depth', '', '<useDepth16UC1Format>{}</useDepth16UC1Format>'.format(flag), KINECT,
       {'depth_encoding': encoding})
      for flag, encoding in (('1', '16UC1'), (' TRUE ', '16UC1'), ('false', '32FC1'),
                             ('0', '32FC1'))),
    # a lens without a function
    *(('wideanglecamera', '<camera>{}</camera>'.format(lens), '', CAMERA,
       {'lens': 'stereographic'}) for lens in ('', '<lens><type>custom</type></lens>'))])
def test_the_settings_of_a_camera(kind, sensor, plugin, library, wanted):
    camera, = read(kind, sensor, plugin, library).cameras
    assert {name: getattr(camera, 'camera_' + name) for name in wanted} == wanted


def test_a_stereo_pair():
    found = read('multicamera', '<camera name="left"><pose>0 0.03 0 0 0 0</pose></camera>'
                 '<camera name="stereo_right"><pose>0 -0.04 0 0 0 0</pose></camera>'
                 '<camera name="top"/>',
                 '<cameraName>eyes</cameraName><hackBaseline>0.07</hackBaseline>', MULTI)
    left, right = found.cameras
    assert (left.camera_y, left.camera_baseline) == (0.03, 0.0)
    assert (right.camera_y, right.camera_baseline) == (-0.04, 0.07)
    assert (left.camera_image_topic, right.camera_info_topic) == (
        'eyes/left/image_raw', 'eyes/right/camera_info')
    assert found.not_simulated == ('camera top, neither left nor right, of sensor c',)


@pytest.mark.parametrize('library', [KINECT, DEPTH])
@pytest.mark.parametrize('plugin, points, limits, encoding', [
    ('', 'eye/points', (0.4, 5.0), '32FC1'),
    ('<pointCloudTopicName>cloud</pointCloudTopicName><pointCloudCutoff>0.1</pointCloudCutoff>'
     '<pointCloudCutoffMax>9</pointCloudCutoffMax><useDepth16UC1Format>true</useDepth16UC1Format>',
     'eye/cloud', (0.1, 9.0), '16UC1')])
def test_depths_and_points(library, plugin, points, limits, encoding):
    camera, = read('depth', '', '<cameraName>eye</cameraName>' + plugin, library).cameras
    assert camera.camera_depth_topic == 'eye/depth/image_raw'
    assert camera.camera_points_topic == points
    # the plugin of depth cameras does not look at the largest depth
    assert (camera.camera_points_min, camera.camera_points_max) == (
        limits if library == KINECT else (limits[0], 10000.0))
    assert camera.camera_depth_encoding == encoding


def test_poses_have_six_numbers():
    names = ['camera_' + name for name in ('x', 'y', 'z', 'roll', 'pitch', 'yaw')]
    pose = '<pose>{} {} {} {} {} {}</pose>'
    for sensor, camera, wanted in (
            ((1, 2, 3, 0.4, 0.5, 0.6), None, (1, 2, 3, 0.4, 0.5, 0.6)),
            (None, (1, 2, 3, 0.4, 0.5, 0.6), (1, 2, 3, 0.4, 0.5, 0.6)),
            ((1, 2, 3, 0, 0, math.pi / 2), (0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
             (0.8, 2.1, 3.3, 0.4, 0.5, 0.6 + math.pi / 2))):
        found, = read('camera', (pose.format(*sensor) if sensor else '') + '<camera>{}</camera>'
                      .format(pose.format(*camera) if camera else '')).cameras
        assert [getattr(found, name) for name in names] == pytest.approx(wanted)


@pytest.mark.parametrize('plugin, problems', [
    *(('<distortion{0}>0.1</distortion{0}>'.format(name), ('distortion by the plugin',))
      for name in ('K1', 'K2', 'K3', 'T1', 'T2')),
    ('<distortionK1>0.00000001</distortionK1>', ()), ('<distortionK1>1e-6</distortionK1>', ()),
    ('<normalsTopicName>n</normalsTopicName>', ('normals',)),
    ('<normalsTopicName/>', ())])
def test_what_a_plugin_claims(plugin, problems):
    assert read('camera', '', plugin).not_simulated == tuple(
        problem + ' of sensor c' for problem in problems)
