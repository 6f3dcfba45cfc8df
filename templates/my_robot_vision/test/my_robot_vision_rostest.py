#!/usr/bin/env python3
"""The node in the simulator, as my_robot_vision.test starts both."""
import math
import queue
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from std_srvs.srv import Empty

POST_X, POST_Y, NEAR_M = 0.5, -0.15, 0.6
LIMIT_S = 30.0      # simulated


class DriveTest(unittest.TestCase):
    """The path of the robot."""

    def test_the_robot_drives_to_the_post(self):
        """The robot is near the post in time."""
        messages = queue.Queue()
        rospy.Subscriber('odom', Odometry, messages.put)
        time_s, distance_m = 0.0, math.inf
        while time_s < LIMIT_S and distance_m > NEAR_M:
            try:
                msg = messages.get(timeout=60)
            except queue.Empty:
                self.fail('no odometry for 60 s: see the lines of gazebo')
            time_s, place = msg.header.stamp.to_sec(), msg.pose.pose.position
            distance_m = math.hypot(place.x - POST_X, place.y - POST_Y)
        self.assertLessEqual(distance_m, NEAR_M)
        # else the node may be ended while it publishes, and rospy prints an error
        rospy.ServiceProxy('gazebo/pause_physics', Empty)()


if __name__ == '__main__':
    rospy.init_node('test_my_robot_vision')
    rostest.rosrun('my_robot_vision', 'test_my_robot_vision', DriveTest)
