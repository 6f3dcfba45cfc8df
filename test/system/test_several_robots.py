"""Four robots in one world, each with its own images and colors, by img_recog.testing."""
import cv2
import numpy as np
import pytest
import rosgraph
import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image, Imu, JointState, LaserScan

from img_recog.testing import Simulation
from img_recog_helpers.recording import Recorder
from img_recog_helpers.waiting import wait_for

LIST = '''\
- {name: tb3_0, x_pos: -1.0, y_pos: -2.0, camera: blue.png, colors: slow.yaml}
# it stands, and looks at the one before
- {name: tb3_1, x_pos: 0.0, y_pos: -2.0, yaw: 3.14159, camera: black.png}
- {name: tb3_2, x_pos: -1.0, y_pos: 1.5, camera: red.png, colors: to_red.yaml}
# a blue post stands ahead of it
- {name: tb3_3, x_pos: -0.75, y_pos: -0.15, camera: robot, colors: slow.yaml}
'''
FILES = {'robots.yaml': LIST,
         'slow.yaml': 'blue_linear_x: 0.2\nred_linear_x: -0.2\n',
         'to_red.yaml': 'blue_linear_x: -0.1\nred_linear_x: 0.1\n'}
IMAGES = {'blue': (255, 0, 0), 'red': (80, 0, 255), 'black': (0, 0, 0)}      # BGR
# what the robot does: the velocities that its node commands, and how far it goes
DRIVES = {'tb3_0': ({0.2}, 0.3), 'tb3_1': (set(), 0.0), 'tb3_2': ({0.1}, 0.3),
          'tb3_3': ({0.2}, 0.3)}


@pytest.fixture(scope='module')
def sim(tmp_path_factory):
    folder = tmp_path_factory.mktemp('robots')
    for name, text in FILES.items():
        (folder / name).write_text(text)
    for name, color in IMAGES.items():
        assert cv2.imwrite(str(folder / (name + '.png')), np.full((48, 64, 3), color, np.uint8))
    with Simulation(robots=str(folder / 'robots.yaml'), recognition=True, image_width=320,
                    image_height=240, framerate=10) as sim:
        yield sim


def test_each_obeys_its_own_colors_and_two_that_meet_see_each_other(sim):
    commands = {name: Recorder('/{}/cmd_vel'.format(name), Twist) for name in DRIVES}
    scans = [Recorder('/{}/scan'.format(name), LaserScan) for name in ('tb3_0', 'tb3_1')]
    for name, recorder in commands.items():
        recorder.wait_connected('/{}/color_extract'.format(name))
    for recorder in scans:
        recorder.wait_connected('/gazebo')
    begin = {name: sim.pose(name) for name in DRIVES}

    def have_driven():
        sim.step(0.1)
        return all(sim.pose(name).x >= begin[name].x + distance - 0.01
                   for name, (_, distance) in DRIVES.items())
    wait_for(have_driven, lambda: [sim.pose(name) for name in DRIVES])
    for name, (speeds, distance) in DRIVES.items():
        assert abs(sim.pose(name).y - begin[name].y) < 0.1
        assert {msg.linear.x for msg in commands[name].messages} - {0.0} == speeds, name
        assert {msg._connection_header['callerid'] for msg in commands[name].messages} <= {
            '/{}/color_extract'.format(name)}

    def are_near():
        sim.step(0.2)
        return all(min(each.messages[-1].ranges[0], each.messages[-1].ranges[-1]) < 0.4
                   for each in scans)
    wait_for(are_near, lambda: [sim.pose(name) for name in DRIVES])
    fronts = [{msg.header.stamp.to_nsec(): msg.ranges[0] for msg in list(each.messages)}
              for each in scans]
    common = sorted(set(fronts[0]) & set(fronts[1]))
    for front in fronts:
        assert front[common[0]] > front[common[-1]]
    # the same distance from both sides, at the same time
    assert len(common) > 3 and all(fronts[0][stamp] == pytest.approx(fronts[1][stamp], abs=0.08)
                                   for stamp in common if fronts[0][stamp] < 3)
    for recorder in (*commands.values(), *scans):
        recorder.close()


@pytest.mark.parametrize('name', DRIVES)
def test_topics_and_frames_are_those_of_the_robot(sim, name):
    sim.step(0.5)
    sent = {topic: Recorder('/{}/{}'.format(name, topic), kind) for topic, kind in (
        ('imu', Imu), ('scan', LaserScan), ('usb_cam/image_raw', Image),
        ('joint_states', JointState))}

    def are_there():
        sim.step(0.1)
        return all(each.messages for each in sent.values())
    wait_for(are_there, name)
    for topic, frame in (('imu', 'imu_link'), ('scan', 'base_scan'),
                         ('usb_cam/image_raw', 'head_camera')):
        assert sent[topic].messages[0].header.frame_id == '{}/{}'.format(name, frame)
    assert sent['joint_states'].messages[0].name == ['wheel_right_joint', 'wheel_left_joint']
    for each in sent.values():
        each.close()


def test_no_topic_is_that_of_a_single_robot(sim):
    published = {topic for topic, _ in rosgraph.Master('/test').getPublishedTopics('')}
    assert not published & {'/odom', '/scan', '/imu', '/joint_states', '/cmd_vel',
                            '/usb_cam/image_raw', '/blue_image'}


def test_tf_of_each_robot_has_its_prefix(sim):
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer)
    pairs = [('{}/odom'.format(name), '{}/{}'.format(name, frame)) for name in DRIVES
             for frame in ('base_footprint', 'base_scan', 'wheel_left_link', 'imu_link')]
    # the transform of the camera comes from another publisher
    pairs.append(('tb3_3/odom', 'tb3_3/head_camera'))

    def is_complete():
        sim.step(0.1)
        return all(buffer.can_transform(*pair, rospy.Time()) for pair in pairs)
    wait_for(is_complete, lambda: buffer.all_frames_as_yaml())
    assert not buffer.can_transform('tb3_0/odom', 'tb3_1/odom', rospy.Time())
