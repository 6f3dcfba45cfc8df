"""The burger driven through ROS: as it is commanded, by its scan, and by the colors it sees.

Written with img_recog.testing, as tests of other packages are: time waits for each answer.
"""
import contextlib
import math
import os

import numpy as np
import pytest
import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, JointState, LaserScan, PointCloud

from img_recog.testing import Simulation
from img_recog.testing.topics import pose_from_msg
from img_recog_helpers import turtlebot3_world
from img_recog_helpers.pages import ROOT
from img_recog_helpers.recording import Recorder, from_node
from img_recog_helpers.waiting import wait_for

START = -2.0, -0.5
FOCAL_PX = 320 / math.tan(math.radians(62.2) / 2)
# a circle around the burger seen from above: x of its center from base_footprint, and radius, m
CENTER_X, RADIUS = -0.032, 0.112


@contextlib.contextmanager
def driven(command, **arguments):
    """Run a simulation in which this process answers each scan by a command."""
    with Simulation(camera='none', lockstep='cmd_vel', lockstep_sensors='scan',
                    **arguments) as sim:
        commands = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
        answers = rospy.Subscriber('/scan', LaserScan, lambda msg: commands.publish(command(msg)),
                                   tcp_nodelay=True)
        try:
            yield sim
        finally:
            answers.unregister()
            commands.unregister()


def twist(linear, angular):
    msg = Twist()
    msg.linear.x, msg.angular.z = linear, angular
    return msg


def path(sim, seconds):
    """Let time pass; return the poses by the odometry meanwhile."""
    odometry = Recorder('/odom', Odometry)
    odometry.wait_connected('/gazebo')
    sim.step(seconds)
    wait_for(lambda: pose_from_msg(odometry.messages[-1]) == sim.pose(), 'the newest odometry')
    odometry.close()
    return list(map(pose_from_msg, odometry.messages))


def test_it_drives_and_turns_as_commanded():
    commanded = [0.22, 0.0]
    with driven(lambda scan: twist(*commanded), world='empty') as sim:
        first, *_, last = (pose for pose in path(sim, 6.0) if pose.linear > 0.21)
        assert (last.x - first.x) / (last.time_s - first.time_s) == pytest.approx(0.22, rel=0.02)
        assert last.x > first.x + 1.0 and abs(last.y - first.y) < 0.01
        moving = sim.message('/odom', Odometry).twist.twist.linear
        assert (moving.x, moving.y) == pytest.approx((0.22, 0.0), abs=0.0044)
        rim = np.array(sim.message('/joint_states', JointState).velocity) * 0.033
        assert rim == pytest.approx(0.22, abs=0.005)
        commanded[:] = 0.0, 0.0
        sim.wait_until(lambda: abs(sim.pose().linear) < 0.002)
        commanded[:] = 0.0, 1.0
        first, *_, last = poses = [pose for pose in path(sim, 8.0) if pose.angular > 0.98]
        turned = np.ptp(np.unwrap([pose.yaw for pose in poses]))
        assert turned > 2 * math.pi
        assert turned / (last.time_s - first.time_s) == pytest.approx(1.0, abs=0.03)
        assert math.dist(first[:2], last[:2]) < 0.03


class Driver:
    """Drives ahead, steers away from near obstacles, and turns in place before an obstacle."""

    _turn = 0.0

    def command(self, scan):
        angles = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment
        angles = (angles + math.pi) % (2 * math.pi) - math.pi
        ranges = np.minimum(scan.ranges, scan.range_max)
        ahead = ranges[np.abs(angles) < math.radians(45)].min()
        left, right = (ranges[np.abs(angles - side * math.radians(60)) < math.radians(50)].min()
                       for side in (1, -1))
        if ahead < 0.4:
            self._turn = self._turn or math.copysign(1.0, left - right)
            return twist(0.0, self._turn)
        self._turn = 0.0
        return twist(0.2, min(left, 0.6) - min(right, 0.6))


def test_a_minute_by_its_scan_without_a_collision():
    with driven(Driver().command, world='turtlebot3_world') as sim:
        places = np.array([(pose.x + CENTER_X * math.cos(pose.yaw),
                            pose.y + CENTER_X * math.sin(pose.yaw)) for pose in path(sim, 60.0)])
    assert min(map(turtlebot3_world.clearance, places)) > RADIUS
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).sum() > 9.0
    # it does not only drive in a small circle
    assert np.ptp(places, axis=0).min() > 1.0


class Seen:
    """What a robot that drives by its camera sees and does, recorded from the start."""

    def __init__(self, until, **arguments):
        """until(sim): lets time pass."""
        with Simulation(recognition=True, lockstep='color_extract/processed', **arguments) as sim:
            self.odometry, self.scans = Recorder('/odom', Odometry), Recorder('/scan', LaserScan)
            self.detections = Recorder('/color_detection', PointCloud)
            self.commands = Recorder('/cmd_vel', Twist, from_node('/color_extract'))
            self.images, self.infos = (Recorder('/usb_cam/' + name, kind, from_node('/gazebo'))
                                       for name, kind in (('image_raw', Image),
                                                          ('camera_info', CameraInfo)))
            for each in (self.odometry, self.scans, self.images, self.infos):
                each.wait_connected('/gazebo')
            for each in (self.detections, self.commands):
                each.wait_connected('/color_extract')
            until(sim)
            self.tf = tf2_ros.Buffer()
            tf2_ros.TransformListener(self.tf)
            wait_for(lambda: self.tf.can_transform('base_footprint', 'head_camera', rospy.Time()),
                     'tf from base_footprint to head_camera')
            wait_for(lambda: self.detections.messages[-1].header.stamp
                     == self.images.messages[-1].header.stamp, 'the newest results')

    def areas(self, color):
        """Return the stamp and the area in pixels of a color, of each image."""
        return [(msg.header.stamp.to_sec(), channel.values[number])
                for msg in self.detections.messages
                for number, channel in enumerate(msg.channels) if channel.name == color]

    def poses(self, until_s=math.inf):
        return [pose for pose in map(pose_from_msg, self.odometry.messages)
                if pose.time_s <= until_s]


def rests(sim, beyond_x=-9.0):
    """Let time pass until the robot has gone beyond x and stands for 1.5 s."""
    sim.wait_until(lambda: sim.pose().x > beyond_x)

    def stands():
        before = sim.pose()
        sim.step(1.5)
        after = sim.pose()
        return math.dist(before[:2], after[:2]) < 0.002 and abs(after.yaw - before.yaw) < 0.005
    sim.wait_until(stands)


def test_the_articles_colors_drive_to_blue_until_it_is_out_of_the_picture():
    seen = Seen(lambda sim: rests(sim, START[0] + 0.5))
    areas = seen.areas('blue')
    large = [area for _, area in areas if area > 1000]
    assert len(large) > 5 and large[0] < 2500 and max(large) > 2.5 * large[0]
    assert areas[-1][1] == 0
    assert {(msg.linear.x, msg.angular.z) for msg in seen.commands.messages} == {(10.0, 0.0)}
    # beside the post at 0.5, -0.15 it is out of the picture; then no command comes, and after
    # half a second the simulator brakes the robot from 2.2 m/s by 1 m/s^2; wheels that slip
    # bend the way, as in Gazebo
    there = seen.poses(max(stamp_s for stamp_s, area in areas if area > 1000))[-1]
    last = seen.poses()[-1]
    assert -1.2 < there.x < 0.3 and there.x < last.x < 5.0 and abs(last.y - START[1]) < 4
    check_the_topics_of_the_camera(seen)


def check_the_topics_of_the_camera(seen):
    stamps = [[msg.header.stamp.to_nsec() for msg in each.messages]
              for each in (seen.images, seen.infos)]
    assert len(stamps[0]) > 100 and set(stamps[0]) & set(stamps[1])
    for each in stamps:
        assert sorted(set(each)) == each and {stamp % 33000000 for stamp in each} == {0}
    assert {(msg.header.frame_id, msg.encoding, msg.width, msg.height, msg.step)
            for msg in seen.images.messages} == {('head_camera', 'rgb8', 640, 480, 1920)}
    info = seen.infos.messages[0]
    assert (info.header.frame_id, info.width, info.height, info.distortion_model) == (
        'head_camera', 640, 480, 'plumb_bob')
    assert info.K == pytest.approx((FOCAL_PX, 0, 320, 0, FOCAL_PX, 240, 0, 0, 1), abs=0.6)
    found = seen.tf.lookup_transform('base_footprint', 'head_camera', rospy.Time()).transform
    place, turn = found.translation, found.rotation
    assert (place.x, place.y, place.z) == pytest.approx((0.033, 0.0, 0.163), abs=1e-6)
    # x to the right, z forward
    assert np.array((turn.x, turn.y, turn.z, turn.w)) * math.copysign(1.0, turn.w) == \
        pytest.approx((-0.5, 0.5, -0.5, 0.5), abs=1e-6)


def test_the_articles_colors_drive_away_from_red_until_it_is_small():
    seen = Seen(lambda sim: sim.step(2.5), yaw=3.14159)
    end_s = next(stamp_s for stamp_s, area in seen.areas('red') if area <= 1000)
    areas = [area for stamp_s, area in seen.areas('red') if stamp_s < end_s]
    assert len(areas) > 5 and 4000 < areas[0] < 7000
    assert max(np.diff(areas)) < 100
    poses = seen.poses(end_s)
    places = [pose.x for pose in poses]
    assert places[0] == pytest.approx(START[0], abs=0.05)
    # the post is at -3.4; it has 1000 pixels at 3.2 m
    assert -0.9 < places[-1] < 0.3 and min(np.diff(places)) > -0.002
    assert all(abs(abs(pose.yaw) - math.pi) < 0.2 for pose in poses)
    first = seen.commands.messages[0]
    assert (first.linear.x, first.angular.z) == (-10.0, 0.0)


def test_the_colors_of_follow_yaml_stop_before_a_post():
    # the shares in it hold at every size
    seen = Seen(rests, image_width=320, image_height=240, x_pos=-0.8,
                colors=os.path.join(ROOT, 'config', 'follow.yaml'))
    robot, post = seen.poses()[-1], (0.5, -0.15)
    assert 0.4 < math.dist((robot.x, robot.y), post) - 0.06 < 0.6
    assert abs(math.atan2(post[1] - robot.y, post[0] - robot.x) - robot.yaw) < 0.25
    assert min(min(scan.ranges) for scan in seen.scans.messages) > 0.24
