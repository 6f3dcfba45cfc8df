#!/usr/bin/env python3
"""The burger in the empty world, driven through ROS: distance, straightness and rotation."""
import math
import unittest

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from img_recog_helpers.driven import place, yaw
from img_recog_helpers.recording import Recorder, call, main, wait_for


def twist(linear, angular):
    msg = Twist()
    msg.linear.x, msg.angular.z = linear, angular
    return msg


def stamp(msg):
    return msg.header.stamp.to_sec()


def position(msg):
    return np.array(place(msg))


def is_at_rest(msg):
    """Return whether the robot stands at the origin."""
    speed = msg.twist.twist
    return (np.linalg.norm(position(msg)) < 0.01 and abs(yaw(msg)) < 0.01
            and max(abs(speed.linear.x), abs(speed.angular.z)) < 0.005)


class MotionTest(unittest.TestCase):
    """Each test starts with the robot at rest at the origin."""

    @classmethod
    def setUpClass(cls):
        cls.commands = rospy.Publisher('/cmd_vel', Twist, queue_size=10)
        wait_for(lambda: cls.commands.get_num_connections(), 'the simulator')

    def setUp(self):
        call('/gazebo/reset_world')
        self.odometry = Recorder('/odom', Odometry)
        self.joints = Recorder('/joint_states', JointState)
        # not only of the first test: messages from before the reset may arrive late
        wait_for(lambda: self.odometry.messages and is_at_rest(self.odometry.messages[-1]),
                 lambda: 'the robot at rest at the origin: {}'.format(self.odometry.messages[-1:]))

    def _drive(self, linear, angular, simulated_s):
        """Send one command; return the odometry of the given time after the robot has started.

        Ten times as fast as real time, much simulated time passes before the command arrives.
        """
        first = len(self.odometry.messages)
        self.commands.publish(twist(linear, angular))

        wait_for(lambda: not is_at_rest(self.odometry.messages[-1]), 'the robot to start')
        start = next(number for number, msg in enumerate(self.odometry.messages)
                     if number >= first and not is_at_rest(msg))
        end_s = stamp(self.odometry.messages[start]) + simulated_s
        wait_for(lambda: stamp(self.odometry.messages[-1]) > end_s,
                 '{} simulated seconds'.format(simulated_s))
        return self.odometry.messages[start:]

    def test_five_meters_straight(self):
        driven = self._drive(0.22, 0.0, 26.0)
        first = next(msg for msg in driven if msg.twist.twist.linear.x > 0.21)
        last = next(msg for msg in driven if position(msg)[0] > position(first)[0] + 5.0)
        along, across = position(last) - position(first)
        self.assertAlmostEqual(0.22, along / (stamp(last) - stamp(first)), delta=0.02 * 0.22)
        self.assertLess(abs(across), 0.02)
        self.assertAlmostEqual(0.22, last.twist.twist.linear.x, delta=0.02 * 0.22)
        self.assertAlmostEqual(0.0, last.twist.twist.linear.y, delta=0.01)
        rim = np.array(self.joints.wait()[-1].velocity) * 0.033
        self.assertLess(np.abs(rim - 0.22).max(), 0.005)

    def test_ten_turns_in_place(self):
        turned = self._drive(0.0, 1.0, 65.0)
        first = next(msg for msg in turned if msg.twist.twist.angular.z > 0.98)
        angles = np.unwrap([yaw(msg) for msg in turned[turned.index(first):]])
        count = int(np.argmax(angles > angles[0] + 20 * math.pi))
        self.assertGreater(count, 0)
        last = turned[turned.index(first) + count]
        self.assertAlmostEqual(1.0, (angles[count] - angles[0]) / (stamp(last) - stamp(first)),
                               delta=0.03)
        self.assertLess(np.linalg.norm(position(last) - position(first)), 0.03)

    def test_speed_ramps_up_at_one_meter_per_second_squared(self):
        driven = self._drive(10.0, 0.0, 1.5)
        moving = next(msg for msg in driven if msg.twist.twist.linear.x > 0.005)
        later = next(msg for msg in driven if stamp(msg) > stamp(moving) + 0.4999)
        # relative to the first message: a busy machine may drop those before it
        gained = later.twist.twist.linear.x - moving.twist.twist.linear.x
        self.assertGreater(gained / (stamp(later) - stamp(moving)), 0.75)
        self.assertLess(gained / (stamp(later) - stamp(moving)), 1.1)


if __name__ == '__main__':
    main(MotionTest)
