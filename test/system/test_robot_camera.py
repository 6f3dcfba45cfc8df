"""Cameras of a robot's <gazebo> tags: topics, frames and values are those of Gazebo's plugins."""
import json
import math
import sys

import pytest

from img_recog_helpers.sdf import BOX, BUILT_IN, sdf
from img_recog_helpers.simulator_tools import burger, complaints
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master
# like that of the waffle of turtlebot3_description, but of fewer pixels
DEPTH = '''<gazebo reference="camera_link"><sensor type="depth" name="realsense_R200">
<camera><horizontal_fov>1.3439</horizontal_fov><image><width>64</width><height>48</height></image>
<clip><near>0.03</near><far>100</far></clip></camera>
<plugin name="camera_controller" filename="libgazebo_ros_openni_kinect.so">
<updateRate>30.0</updateRate><cameraName>camera</cameraName><frameName>lens</frameName>
<imageTopicName>rgb/image_raw</imageTopicName>
<depthImageTopicName>depth/image_raw</depthImageTopicName>
<cameraInfoTopicName>rgb/camera_info</cameraInfoTopicName>
<depthImageCameraInfoTopicName>depth/camera_info</depthImageCameraInfoTopicName>
<pointCloudTopicName>depth/points</pointCloudTopicName></plugin></sensor></gazebo>'''
# a red wall whose near side is 2 m in front of the origin
WALL = ('<model name="wall"><static>1</static><pose>2.05 0 0.5 0 0 0</pose><link name="l">'
        + BOX.format('collision', '', '0.1 4 1') + BOX.format('visual', '', '0.1 4 1').replace(
            '</visual>', '<material><ambient>1 0 0 1</ambient><diffuse>1 0 0 1</diffuse>'
            '</material></visual>')
        + '</link></model>')
WATCH = r'''
import json, sys
import cv2, numpy, rospy, tf2_ros
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2

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
    elif isinstance(msg, PointCloud2):
        points = numpy.frombuffer(msg.data, '<f4').reshape(msg.height, msg.width, -1)
        row['middle'] = points[msg.height // 2, msg.width // 2, :3].tolist()
    sys.stdout.write(json.dumps(row) + '\n')     # at once: each topic has a thread
    sys.stdout.flush()

rospy.init_node('watch', anonymous=True)
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
for name, kind in (('rgb/image_raw', Image), ('rgb/camera_info', CameraInfo),
                   ('rgb/image_raw/compressed', CompressedImage),
                   ('depth/image_raw', Image), ('depth/camera_info', CameraInfo),
                   ('depth/points', PointCloud2)):
    rospy.Subscriber('/camera/' + name, kind, lambda msg, name=name: show(name, msg))
while not buffer.can_transform('camera_link', 'lens', rospy.Time(0)) and not rospy.is_shutdown():
    rospy.rostime.wallsleep(0.1)
turn = buffer.lookup_transform('camera_link', 'lens', rospy.Time(0)).transform.rotation
sys.stdout.write(json.dumps({'topic': 'tf', 'turn': [turn.x, turn.y, turn.z, turn.w]}) + '\n')
sys.stdout.flush()
rospy.spin()
'''


@pytest.fixture
def world(tmp_path):
    """The argument for a world with a wall."""
    (tmp_path / 'wall.world').write_text(sdf(BUILT_IN, WALL))
    return '_world:={}'.format(tmp_path / 'wall.world')


def watch(ros):
    """Return the newest message of each topic, and a transform, when there are all."""
    process = ros.start(sys.executable, '-c', WATCH)

    def newest():
        rows = [json.loads(line) for line in process.output.split('\n')[:-1]
                if line.startswith('{')]
        found = {row['topic']: row for row in rows}
        return found if len(found) == 7 else None
    return wait_for(newest, lambda: 'messages of all topics; ' + process.output[-500:])


def test_a_depth_camera_sees_color_and_distance_of_a_wall(ros, simulate, world):
    node = simulate(world, '_x_pos:=0', '_y_pos:=0', urdf=burger(DEPTH))
    seen = watch(ros)
    assert {row['frame'] for row in seen.values() if 'frame' in row} == {'lens'}
    assert all(row['size'] == [64, 48] for row in seen.values() if 'size' in row)
    color, depth = seen['rgb/image_raw'], seen['depth/image_raw']
    assert (color['encoding'], depth['encoding']) == ('rgb8', '32FC1')
    red, green, blue = color['middle']
    assert red == pytest.approx(102, abs=4) and green == blue == 0     # as in Gazebo, in the shade
    compressed = seen['rgb/image_raw/compressed']
    assert compressed['encoding'] == 'rgb8; jpeg compressed bgr8'
    assert compressed['middle'] == pytest.approx(color['middle'], abs=4)
    # camera_link of the burger is 0.02 m in front of base_link, which is above the origin
    camera_x = float(burger().split('<child link="camera_link"/>')[1].split('xyz="')[1].split()[0])
    assert depth['middle'] == pytest.approx([2.0 - camera_x], abs=2e-3)
    focal = 32 / math.tan(1.3439 / 2)
    # half a pixel to the right of the axis and below it
    aside = 0.5 / focal * depth['middle'][0]
    assert seen['depth/points']['middle'] == pytest.approx([aside, aside, *depth['middle']],
                                                           abs=2e-3)
    for topic in ('rgb/camera_info', 'depth/camera_info'):
        assert seen[topic]['K'] == pytest.approx([focal, 0, 31.5, 0, focal, 23.5, 0, 0, 1])
    assert seen['tf']['turn'] == pytest.approx([-0.5, 0.5, -0.5, 0.5], abs=1e-3)
    assert complaints(node) == []


# several sensors in one link: like the lens of the robot for AutoRace, and a stereo pair
WIDE = '''<sensor type="wideanglecamera" name="wide"><camera><horizontal_fov>3.183</horizontal_fov>
<image><width>320</width><height>240</height></image><lens><type>equidistant</type>
<cutoff_angle>3.1415</cutoff_angle></lens></camera><plugin name="w"
filename="libgazebo_ros_camera.so"><cameraName>wide</cameraName></plugin></sensor>'''
STEREO = '''<sensor type="multicamera" name="eyes"><camera name="left"><pose>0 0.2 0 0 0 0</pose>
</camera><camera name="right"><pose>0 -0.2 0 0 0 0</pose></camera><plugin name="m"
filename="libgazebo_ros_multicamera.so"><cameraName>eyes</cameraName><frameName>eyes</frameName>
<hackBaseline>0.4</hackBaseline></plugin></sensor>'''
WATCH_INFOS = r'''
import json, sys
import rospy
from sensor_msgs.msg import CameraInfo, Image
rospy.init_node('watch', anonymous=True)
for name in ('wide', 'eyes/left', 'eyes/right'):
    info = rospy.wait_for_message('/{}/camera_info'.format(name), CameraInfo)
    image = rospy.wait_for_message('/{}/image_raw'.format(name), Image)
    sys.stdout.write(json.dumps([name, info.distortion_model, info.D, info.K, info.P[3],
                                 image.width]) + chr(10))
sys.stdout.flush()
'''


def test_several_sensors_in_one_link(ros, simulate, world):
    node = simulate(world, '_x_pos:=0', '_y_pos:=0', urdf=burger(
        '<gazebo reference="camera_link">' + WIDE + STEREO + '</gazebo>'))
    process = ros.start(sys.executable, '-c', WATCH_INFOS)
    wide, left, right = wait_for(
        lambda: [json.loads(line) for line in process.output.split('\n') if line[:1] == '[']
        if process.output.count('\n[') >= 2 else None, lambda: process.output + node.output)
    focal = 320 / 3.183
    assert wide[1:3] == ['equidistant', [0.0] * 4] and wide[5] == 320
    assert wide[3] == pytest.approx([focal, 0, 159.5, 0, focal, 119.5, 0, 0, 1])
    assert left[1] == right[1] == 'plumb_bob' and left[5] == 320
    assert (left[4], right[4]) == pytest.approx((0.0, -0.4 * right[3][0]))
    assert complaints(node) == []
