#!/usr/bin/env python3
"""Four robots in one world, each with its own images and colors."""
import math
import unittest

import numpy as np
import rosgraph
import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, Imu, JointState, LaserScan

from img_recog_helpers.recording import Recorder, call, main, wait_for

NAMES = ['tb3_{}'.format(number) for number in range(4)]
# what the robot of that number does: the velocities that its node commands
COMMANDS = {'tb3_0': {0.2}, 'tb3_1': set(), 'tb3_2': {0.1}, 'tb3_3': {0.2}}
# of robots_list.py
STARTS = {'tb3_0': (-1.0, -2.0), 'tb3_1': (0.0, -2.0), 'tb3_2': (-1.0, 1.5),
          'tb3_3': (-0.75, -0.15)}


def position(msg):
    """Return x and y of an odometry."""
    return np.array((msg.pose.pose.position.x, msg.pose.pose.position.y))


class SeveralRobotsTest(unittest.TestCase):
    """The robots drive from their starts; what they do is recorded once, for all tests."""

    @classmethod
    def setUpClass(cls):
        cls.odometry = {name: Recorder('/{}/odom'.format(name), Odometry) for name in NAMES}
        cls.scans = {name: Recorder('/{}/scan'.format(name), LaserScan) for name in NAMES[:2]}
        cls.commands = {name: Recorder('/{}/cmd_vel'.format(name), Twist) for name in NAMES}
        for recorder in (*cls.odometry.values(), *cls.scans.values()):
            recorder.wait()
        for name in NAMES:
            cls.commands[name].wait_connected('/{}/color_extract'.format(name))
        cls._begin_again()

    @classmethod
    def _begin_again(cls):
        """Move the robots to their starts, and forget what was before: some may have arrived."""
        call('/gazebo/reset_world')
        # what was sent before may still be on its way, from robots that have hardly left
        after = rospy.Time.now() + rospy.Duration(0.1)

        def stamps():       # they may drive away at once
            found = [[msg.header.stamp for msg in list(cls.odometry[name].messages)
                      if msg.header.stamp > after and math.dist(position(msg), start) < 0.05]
                     for name, start in STARTS.items()]
            return [each[-1] for each in found] if all(found) else None
        since = max(wait_for(stamps, 'the robots at their starts'))
        for recorder in (*cls.odometry.values(), *cls.scans.values()):
            recorder.forget(since)
            recorder.wait()

    def start(self, name):
        return position(self.odometry[name].messages[0])

    def place(self, name):
        return position(self.odometry[name].messages[-1])

    def test_each_obeys_its_own_colors(self):
        for name, goal in (('tb3_0', (0.3, 0)), ('tb3_2', (0.3, 0)), ('tb3_3', (0.3, 0))):
            begin = self.start(name)
            wait_for(lambda: self.place(name)[0] > begin[0] + goal[0],
                     lambda: '{} to drive forward: {}'.format(name, self.place(name) - begin))
            self.assertLess(abs(self.place(name)[1] - begin[1]), 0.1)
        for name, speeds in COMMANDS.items():
            messages = list(self.commands[name].messages)
            nodes = {msg._connection_header['callerid'] for msg in messages}
            self.assertLessEqual(nodes, {'/{}/color_extract'.format(name)})
            self.assertEqual(speeds, {msg.linear.x for msg in messages} - {0.0}, name)

    def test_two_that_meet_see_each_other_in_their_scans(self):
        fronts = {}
        for name, recorder in self.scans.items():
            wait_for(lambda: recorder.messages and min(recorder.messages[-1].ranges[0],
                                                       recorder.messages[-1].ranges[-1]) < 0.4,
                     lambda: '{} to see the other: {}'.format(
                         name, [msg.ranges[0] for msg in recorder.messages]))
            fronts[name] = [msg.ranges[0] for msg in list(recorder.messages)]
        for front in fronts.values():
            self.assertGreater(front[0], front[-1])
        # the same distance from both sides, at the same time
        first, second = ({msg.header.stamp.to_nsec(): msg.ranges[0]
                          for msg in list(recorder.messages)} for recorder in self.scans.values())
        common = sorted(set(first) & set(second))
        self.assertGreater(len(common), 3)
        for stamp in common:
            if max(first[stamp], second[stamp]) < 3:
                self.assertAlmostEqual(first[stamp], second[stamp], delta=0.08)

    def test_topics_and_frames_are_those_of_the_robot(self):
        for name in NAMES:
            odometry = self.odometry[name].messages[0]
            self.assertEqual((name + '/odom', name + '/base_footprint'),
                             (odometry.header.frame_id, odometry.child_frame_id))
            for topic, kind, frame in (('imu', Imu, '/imu_link'),
                                       ('scan', LaserScan, '/base_scan'),
                                       ('usb_cam/image_raw', Image, '/head_camera')):
                recorder = Recorder('/{}/{}'.format(name, topic), kind)
                self.assertEqual(name + frame, recorder.wait()[0].header.frame_id)
                recorder.close()
            joints = Recorder('/{}/joint_states'.format(name), JointState)
            self.assertEqual(['wheel_right_joint', 'wheel_left_joint'], joints.wait()[0].name)
            joints.close()
        published = {topic for topic, _ in rosgraph.Master('/test').getPublishedTopics('')}
        self.assertFalse(published & {'/odom', '/scan', '/imu', '/joint_states', '/cmd_vel',
                                      '/usb_cam/image_raw', '/blue_image'}, published)

    def test_tf_of_each_robot_has_its_prefix(self):
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        for name in NAMES:
            for frame in ('base_scan', 'wheel_left_link', 'imu_link'):
                pair = name + '/odom', '{}/{}'.format(name, frame)
                wait_for(lambda: buffer.can_transform(*pair, rospy.Time()), '{} to {}'.format(
                    *pair))
        wait_for(lambda: buffer.can_transform('tb3_3/odom', 'tb3_3/head_camera', rospy.Time()),
                 'the camera, whose transform comes from another publisher')
        self.assertFalse(buffer.can_transform('tb3_0/odom', 'tb3_1/odom', rospy.Time()))


if __name__ == '__main__':
    main(SeveralRobotsTest)
