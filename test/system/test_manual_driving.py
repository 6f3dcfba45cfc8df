"""./run manual: dqn and autorace, with an environment, a course and nodes of this test."""
import os
import re

import cv2
import numpy as np
import pytest

from img_recog_testing.gazebo_messages import INSTALLED, write_package
from img_recog_testing.manual import Workspace
from img_recog_testing.simulator_tools import burger

# wants of the simulator what that of turtlebot3_dqn wants
ENVIRONMENT = """
import math
import rospy
from gazebo_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Pose, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty

MODEL = '''<sdf version="1.6"><model name="mark"><static>1</static><link name="link">
<visual name="box"><geometry><box><size>0.5 0.5 0.001</size></box></geometry></visual>
</link></model></sdf>'''


class Env:
    def __init__(self, actions):
        assert rospy.get_param('/stage_number') == 1 and actions == 5
        self.goals = [(0.6, 0.0), (0.9, 0.4), (0.0, 9.0)]
        self.velocity = rospy.Publisher('cmd_vel', Twist, queue_size=5)
        self.is_new = True

    def getGoal(self):
        return list(self.goals[0])

    def place(self):
        pose = Pose()
        pose.position.x, pose.position.y = self.goals[0]
        service = 'gazebo/spawn_sdf_model'
        rospy.wait_for_service(service)
        assert rospy.ServiceProxy(service, SpawnModel)('goal', MODEL, '', pose, 'world').success

    def observe(self):
        scan = rospy.wait_for_message('scan', LaserScan, 10)
        assert len(scan.ranges) == 360 and min(scan.ranges) < 3.5
        pose = rospy.wait_for_message('odom', Odometry, 10).pose.pose
        yaw = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        x, y = self.goals[0][0] - pose.position.x, self.goals[0][1] - pose.position.y
        heading = math.remainder(math.atan2(y, x) - yaw, 2 * math.pi)
        return [*scan.ranges, heading, math.hypot(x, y), 0, 0]

    def reset(self):
        rospy.wait_for_service('gazebo/reset_simulation')
        rospy.ServiceProxy('gazebo/reset_simulation', Empty)()
        if self.is_new:
            self.place()
            self.is_new = False
        return self.observe()

    def step(self, action):
        twist = Twist()
        twist.linear.x, twist.angular.z = 0.15, 0.75 * (2 - action)
        self.velocity.publish(twist)
        state = self.observe()
        if state[-3] >= 0.2:
            return state, 1.5, False
        self.velocity.publish(Twist())
        assert rospy.ServiceProxy('gazebo/delete_model', DeleteModel)('goal').success
        self.goals.pop(0)
        self.place()
        return state, 200, False
"""
ROOM = """<sdf version="1.6"><world name="default"><model name="wall"><static>1</static>
<pose>2 0 0.5 0 0 0</pose><link name="link"><collision name="box"><geometry><box>
<size>0.1 4 1</size></box></geometry></collision></link></model></world></sdf>"""

# a lane round (0.8, -1.147), on which the robot starts
COURSE = """<sdf version="1.6"><world name="default"><model name="course"><static>1</static>
<pose>0 0 0 0 0 3.14159</pose><link name="link"><visual name="plane"><geometry><plane>
<normal>0 0 1</normal><size>4 4</size></plane></geometry><material><script>
<uri>model://turtlebot3_autorace_2020/course/materials/scripts</uri>
<uri>model://turtlebot3_autorace_2020/course/materials/textures</uri>
<name>course</name></script></material></visual></link></model></world></sdf>"""
CAMERA = """<link name="eye"/><joint name="eye_joint" type="fixed"><parent link="base_link"/>
<child link="eye"/><origin xyz="0.05 0 0.1" rpy="0 0.5 0"/></joint>
<gazebo reference="eye"><sensor name="camera" type="wideanglecamera"><camera>
<horizontal_fov>3</horizontal_fov><image><width>160</width><height>120</height></image>
<lens><type>equidistant</type><scale_to_hfov>true</scale_to_hfov></lens></camera>
<plugin name="camera_controller" filename="libgazebo_ros_camera.so"><updateRate>10</updateRate>
<cameraName>camera</cameraName><imageTopicName>image</imageTopicName>
<cameraInfoTopicName>camera_info</cameraInfoTopicName><frameName>eye</frameName>
</plugin></sensor></gazebo>"""
LAUNCH = '<launch><node name="{0}" pkg="{1}" type="{0}.py" output="screen"/></launch>'
RECTIFY = """#!{python}
import rospy
from sensor_msgs.msg import CameraInfo, Image

rospy.init_node('rectify')
infos = {}
rectified = rospy.Publisher('/camera/image_rect_color', Image, queue_size=1)
rospy.Subscriber('/camera/camera_info', CameraInfo, lambda msg: infos.update(last=msg))

def rectify(msg):
    assert msg.header.frame_id == 'eye' and infos['last'].width == msg.width == 160
    rectified.publish(msg)

rospy.wait_for_message('/camera/camera_info', CameraInfo)
rospy.Subscriber('/camera/image', Image, rectify)
rospy.spin()
"""
DETECT = """#!{python}
import cv2
import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Float64, UInt8

rospy.init_node('detect_lane')
lanes = rospy.Publisher('/detect/lane', Float64, queue_size=1)
images = rospy.Publisher('/detect/white_line_reliability', UInt8, queue_size=1)

def detect(msg):
    assert msg.header.frame_id == 'eye' and np.int(1.5) == 1
    image = cv2.imdecode(np.frombuffer(msg.data, np.uint8), cv2.IMREAD_COLOR)
    blue, green, red = (channel.astype(int) for channel in cv2.split(image))
    yellow, white = green - blue > 60, (blue > 100) & (abs(green - blue) < 30)
    images.publish(100)
    columns = [np.nonzero(line[60:])[1] for line in (yellow, white)]
    if min(map(len, columns)) > 20 and columns[0].mean() < columns[1].mean():
        lanes.publish(np.mean([each.mean() for each in columns]))

rospy.Subscriber('/camera/image_rect_color/compressed', CompressedImage, detect)
rospy.spin()
"""
CONTROL = """#!{python}
import rospy
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64

rospy.init_node('control_lane')
velocity = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
twist = Twist()
twist.linear.x, twist.angular.z = 0.2, 0.2 / 0.6
rospy.Subscriber('/detect/lane', Float64, lambda _: velocity.publish(twist))
rospy.spin()
"""


@pytest.fixture
def workspace(ros, tmp_path):
    return Workspace(tmp_path, ros.env)


def test_dqn_reaches_goals_faster_than_real_time(workspace, tmp_path):
    workspace.add('tf', 'turtlebot3_dqn', 'turtlebot3_gazebo')
    if not INSTALLED:
        for name, path in write_package(tmp_path / 'messages').items():
            workspace.env[name] = os.pathsep.join(filter(None, [path, workspace.env.get(name)]))
    workspace.write('turtlebot3_dqn/src/turtlebot3_dqn/environment_stage_1.py', ENVIRONMENT)
    workspace.write('turtlebot3_gazebo/worlds/turtlebot3_stage_1.world', ROOM)
    code, output = workspace.manual('dqn', '--steps', 40, 'real_time_factor:=2')
    assert code == 0, output
    assert re.search(r'goal 0.6 0.0: reached after \d+ steps\n.*goal 0.9 0.4: reached after',
                     output), output
    summary = re.search(r'40 steps in (\S+) s of simulated time; goals reached: 2, collisions: 0, '
                        r'resets: 1\n.*rewards: sum 457.0, .* 1.5 to 1.5, mean 1.5', output)
    assert summary and float(summary.group(1)) > 38 * 0.2, output      # a step waits for a scan
    assert 'was not there' not in output


def test_an_environment_that_cannot_start_is_one_line(workspace, tmp_path):
    workspace.add('gazebo_msgs', 'tf', 'turtlebot3_dqn', 'turtlebot3_gazebo')
    workspace.write('turtlebot3_dqn/src/turtlebot3_dqn/environment_stage_1.py',
                    "raise OSError('no model of a goal')")
    workspace.write('turtlebot3_gazebo/worlds/turtlebot3_stage_1.world', ROOM)
    code, output = workspace.manual('dqn')
    assert code == 1
    assert re.search(r'\[run\] .*/turtlebot3_dqn has failed: no model of a goal; see ', output)
    assert 'Traceback' not in output


def test_autorace_drives_round_two_corners(workspace):
    workspace.add('image_proc', 'turtlebot3_autorace_camera', 'turtlebot3_autorace_detect',
                  'turtlebot3_autorace_driving', 'turtlebot3_description', 'turtlebot3_gazebo')
    workspace.write('image_proc/nodelet_plugins.xml', '<library/>')
    model = 'turtlebot3_gazebo/models/turtlebot3_autorace_2020/course/materials/'
    workspace.env['GAZEBO_MODEL_PATH'] = str(workspace.folder / 'turtlebot3_gazebo' / 'models')
    workspace.write('turtlebot3_gazebo/worlds/turtlebot3_autorace_2020.world', COURSE)
    workspace.write(model + 'scripts/course.material', 'material course\n{\ntechnique\n{\npass\n'
                    '{\ntexture_unit\n{\ntexture course.png\n}\n}\n}\n}\n')
    picture = np.zeros((800, 800, 3), np.uint8)
    for radius_m, color in ((0.48, (0, 255, 255)), (0.72, (255, 255, 255))):
        # the picture is turned by 180 degrees
        cv2.circle(picture, (round(200 * (2 - 0.8)), round(200 * (2 - 1.147))),
                   round(200 * radius_m), color, 4)
    (workspace.folder / model / 'textures').mkdir()
    assert cv2.imwrite(str(workspace.folder / model / 'textures' / 'course.png'), picture)
    workspace.write('turtlebot3_description/urdf/turtlebot3_burger_for_autorace_2020.urdf.xacro',
                    burger(CAMERA))
    for package, launch, node, text in (
            ('camera', 'intrinsic_camera_calibration', 'rectify', RECTIFY),
            ('detect', 'detect_lane', 'detect_lane', DETECT),
            ('driving', 'turtlebot3_autorace_control_lane', 'control_lane', CONTROL)):
        package = 'turtlebot3_autorace_' + package
        workspace.write('{}/launch/{}.launch'.format(package, launch),
                        LAUNCH.format(node, package))
        workspace.write('{}/{}.py'.format(package, node), text)
    workspace.write('turtlebot3_autorace_camera/launch/extrinsic_camera_calibration.launch',
                    '<launch/>')
    code, output = workspace.manual('autorace', 'real_time_factor:=3')
    assert code == 0, output
    found = re.search(r'the lane was found in (\d+) of (\d+) images', output)
    # 170 degrees of a circle of 0.6 m, at 0.2 m/s and 10 Hz
    assert found and 60 < int(found.group(1)) <= int(found.group(2)) < 120, output
    assert 1.6 < float(re.search(r'corners: 2, distance: (\S+) m', output).group(1)) < 2.0, output
    assert float(re.search(r'middle of the lane: (\S+) m in', output).group(1)) < 0.06, output
