#!/usr/bin/env python3
"""The colors of config/follow.yaml: the robot stops before a post and follows it when it moves."""
import math
import shutil
import unittest

import rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import GetModelState, SetModelState

from img_recog_helpers.driven import Robot, place, yaw
from img_recog_helpers.recording import main, wait_for

POST, RADIUS_M = 'blue_post_1', 0.06
SPEED, PERIOD_S = 0.1, 0.1
# m, from the scanner: the front of the robot is at 0.07
TOUCHING_M = 0.12


class FollowTest(unittest.TestCase):
    """The robot starts with a blue post ahead, a little to the left."""

    @classmethod
    def setUpClass(cls):
        rospy.wait_for_service('/gazebo/set_model_state')
        cls.get = rospy.ServiceProxy('/gazebo/get_model_state', GetModelState)
        cls.set = rospy.ServiceProxy('/gazebo/set_model_state', SetModelState)
        cls.robot = Robot()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(rospy.get_param('~messages'), ignore_errors=True)

    def test_stops_before_a_post_and_follows_it(self):
        self.robot.begin_again()
        self._wait_follows(0.5, -0.15)

        self._push(1.0, 0.0)            # away
        self._wait_follows(1.5, -0.15)
        self._push(0.0, 0.8)            # and aside
        self._wait_follows(1.5, 0.65)
        nearest = min(min(scan.ranges) for scan in self.robot.scans.messages)
        self.assertGreater(nearest, 2 * TOUCHING_M)
        self.assertGreater(len(self.robot.scans.messages), 50)

    def _where(self):
        msg = self.robot.odometry.messages[-1]
        return 'the robot at rest: {}, {}'.format(place(msg), yaw(msg))

    def _post(self):
        """Return where the post is."""
        found = self.get(POST, 'world')
        self.assertTrue(found.success, found.status_message)
        return found.pose.position.x, found.pose.position.y

    def _push(self, along_x, along_y):
        """Move the post in small steps, by simulated time."""
        x, y = self._post()
        state = ModelState(model_name=POST)
        state.pose.position.z = 0.15
        state.pose.orientation.w = 1.0
        steps = math.ceil(math.hypot(along_x, along_y) / SPEED / PERIOD_S)
        for step in range(1, steps + 1):
            state.pose.position.x = x + along_x * step / steps
            state.pose.position.y = y + along_y * step / steps
            answer = self.set(state)
            self.assertTrue(answer.success, answer.status_message)
            rospy.sleep(PERIOD_S)

    def _wait_follows(self, x, y):
        wait_for(lambda: self.robot.rests(1.5) and self._distance() < 0.6, self._where)
        self._check_before_post(x, y)

    def _distance(self):
        """Return the distance from the robot's wheels to the surface of the post."""
        return math.dist(self._post(), place(self.robot.odometry.messages[-1])) - RADIUS_M

    def _check_before_post(self, x, y):
        """Check that the robot faces the post from half a meter, which it has not pushed."""
        self.assertLess(math.dist(self._post(), (x, y)), 0.003)
        self.assertGreater(self._distance(), 0.4)
        robot = self.robot.odometry.messages[-1]
        bearing = math.atan2(y - place(robot)[1], x - place(robot)[0]) - yaw(robot)
        self.assertLess(abs(bearing), 0.25)


if __name__ == '__main__':
    main(FollowTest)
