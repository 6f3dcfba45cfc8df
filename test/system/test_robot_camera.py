"""Cameras of a robot's <gazebo> tags: topics, frames and values are those of Gazebo's plugins."""
import json
import math
import sys

import pytest

from img_recog_testing.sdf import BOX, BUILT_IN, sdf
from img_recog_testing.simulator_tools import burger, complaints
from img_recog_testing.waiting import wait_for

# like that of the waffle of turtlebot3_description, but of fewer pixels
DEPTH = '''<gazebo reference="{link}"><sensor type="depth" name="realsense_R200">
<camera><horizontal_fov>1.3439</horizontal_fov><image><width>64</width><height>48</height></image>
<clip><near>0.03</near><far>100</far></clip></camera>
<plugin name="camera_controller" filename="libgazebo_ros_openni_kinect.so">
<updateRate>30.0</updateRate><cameraName>camera</cameraName><frameName>{frame}</frameName>
<imageTopicName>rgb/image_raw</imageTopicName>
<depthImageTopicName>depth/image_raw</depthImageTopicName>
<cameraInfoTopicName>rgb/camera_info</cameraInfoTopicName>
<depthImageCameraInfoTopicName>depth/camera_info</depthImageCameraInfoTopicName>
</plugin></sensor></gazebo>'''
# a red wall whose near side is 2 m in front of the origin
WALL = ('<model name="wall"><static>1</static><pose>2.05 0 0.5 0 0 0</pose><link name="l">'
        + BOX.format('collision', '', '0.1 4 1') + BOX.format('visual', '', '0.1 4 1').replace(
            '</visual>', '<material><diffuse>1 0 0 1</diffuse></material></visual>')
        + '</link></model>')
WATCH = r'''
import json, sys
import cv2, numpy, rospy, tf2_ros
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

def show(topic, msg):
    row = {'topic': topic, 'stamp': msg.header.stamp.to_sec(), 'frame': msg.header.frame_id}
    if isinstance(msg, CompressedImage):
        pixels = cv2.imdecode(numpy.frombuffer(msg.data, 'u1'), cv2.IMREAD_COLOR)[..., ::-1]
        row.update(encoding=msg.format, size=pixels.shape[1::-1],
                   middle=pixels[pixels.shape[0] // 2, pixels.shape[1] // 2].tolist())
    else:
        row['size'] = [msg.width, msg.height]
    if isinstance(msg, Image):
        row['encoding'], kind = msg.encoding, {'32FC1': '<f4', 'rgb8': 'u1'}[msg.encoding]
        pixels = numpy.frombuffer(msg.data, kind).reshape(msg.height, msg.width, -1)
        row['middle'] = pixels[msg.height // 2, msg.width // 2].tolist()
    elif isinstance(msg, CameraInfo):
        row['K'] = list(msg.K)
    sys.stdout.write(json.dumps(row) + '\n')     # at once: each topic has a thread
    sys.stdout.flush()

rospy.init_node('watch', anonymous=True)
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
for name, kind in (('rgb/image_raw', Image), ('rgb/camera_info', CameraInfo),
                   ('rgb/image_raw/compressed', CompressedImage),
                   ('depth/image_raw', Image), ('depth/camera_info', CameraInfo)):
    rospy.Subscriber('/camera/' + name, kind, lambda msg, name=name: show(name, msg))
'''
TRANSFORM = r'''
while not buffer.can_transform('camera_link', 'lens', rospy.Time(0)) and not rospy.is_shutdown():
    rospy.rostime.wallsleep(0.1)
turn = buffer.lookup_transform('camera_link', 'lens', rospy.Time(0)).transform.rotation
sys.stdout.write(json.dumps({'topic': 'tf', 'turn': [turn.x, turn.y, turn.z, turn.w]}) + '\n')
sys.stdout.flush()
'''


@pytest.fixture
def ros(shared_ros):
    """One master for the tests of this module."""
    return shared_ros


@pytest.fixture
def world(tmp_path):
    """The argument for a world with a wall."""
    (tmp_path / 'wall.world').write_text(sdf(BUILT_IN, WALL))
    return '_world:={}'.format(tmp_path / 'wall.world')


def watch(ros, also=''):
    """Return a function that returns the newest message of each topic when there are all."""
    process = ros.start(sys.executable, '-c', WATCH + also + 'rospy.spin()')
    count = 6 if also else 5

    def newest():
        rows = [json.loads(line) for line in process.output.split('\n')[:-1]
                if line.startswith('{')]
        found = {row['topic']: row for row in rows}
        return found if len(found) == count else None
    return lambda: wait_for(newest, lambda: 'messages of all topics; ' + process.output[-500:])


def test_a_depth_camera_sees_color_and_distance_of_a_wall(ros, simulate, world):
    node = simulate(world, '_x_pos:=0', '_y_pos:=0', urdf=burger(
        DEPTH.format(link='camera_link', frame='lens')))
    seen = watch(ros, TRANSFORM)()
    assert {row['frame'] for row in seen.values() if 'frame' in row} == {'lens'}
    assert all(row['size'] == [64, 48] for row in seen.values() if 'size' in row)
    color, depth = seen['rgb/image_raw'], seen['depth/image_raw']
    assert (color['encoding'], depth['encoding']) == ('rgb8', '32FC1')
    red, green, blue = color['middle']
    assert red > 120 and green == blue == 0
    compressed = seen['rgb/image_raw/compressed']
    assert compressed['encoding'] == 'rgb8; jpeg compressed bgr8'
    assert compressed['middle'] == pytest.approx(color['middle'], abs=4)
    # camera_link of the burger is 0.02 m in front of base_link, which is above the origin
    camera_x = float(burger().split('<child link="camera_link"/>')[1].split('xyz="')[1].split()[0])
    assert depth['middle'] == pytest.approx([2.0 - camera_x], abs=2e-3)
    focal = 32 / math.tan(1.3439 / 2)
    for topic in ('rgb/camera_info', 'depth/camera_info'):
        assert seen[topic]['K'] == pytest.approx([focal, 0, 31.5, 0, focal, 23.5, 0, 0, 1])
    assert seen['tf']['turn'] == pytest.approx([-0.5, 0.5, -0.5, 0.5], abs=1e-3)
    assert complaints(node) == []


@pytest.mark.parametrize('link, frame, words', [
    ('nose', 'lens', 'its <gazebo> tag has the reference nose, which is not a link'),
    ('camera_link', 'camera_link', None)])
def test_a_camera_whose_frames_do_not_fit(ros, simulate, world, link, frame, words):
    node = simulate(world, '_x_pos:=0', '_y_pos:=0', urdf=burger(
        DEPTH.format(link=link, frame=frame)))
    if words is None:
        assert watch(ros)()['rgb/image_raw']['frame'] == 'camera_link'
        warning, = complaints(node)
        assert 'have the frame camera_link, a link that is not turned like an image' in warning
    else:
        assert words in node.fatal_line()


def test_two_cameras_with_the_same_topics(ros, simulate, world):
    node = simulate(world, urdf=burger(DEPTH.format(link='camera_link', frame='a')
                                       + DEPTH.format(link='base_scan', frame='b')))
    assert ('the topic camera/rgb/image_raw is camera_image_topic of the camera on camera_link '
            'and camera_image_topic of the camera on base_scan') in node.fatal_line()
