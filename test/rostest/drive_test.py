#!/usr/bin/env python3
"""The robot drives forward on blue, backward on red, and stands if neither is visible."""
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from std_srvs.srv import Empty

from img_recog_testing.recording import Recorder, wait_for


class DriveTest(unittest.TestCase):
    """Checks odometry and log while the synthetic camera shows all cards once."""

    @classmethod
    def setUpClass(cls):
        cls.odometry = Recorder('/odom', Odometry)
        cls.log = Recorder('/rosout', Log, lambda msg: msg.msg.startswith('blue='))
        cls.odometry.wait()

    def _speed(self):
        return self.odometry.messages[-1].twist.twist.linear.x

    def _areas(self):
        """Return the areas that color_extract logged last."""
        if not self.log.messages:
            return None
        return tuple(int(part.split('=')[1]) for part in self.log.messages[-1].msg.split(', '))

    def _wait_areas(self, blue, red):
        wait_for(lambda: self._areas() is not None and (self._areas()[0] > 1000) == blue
                 and (self._areas()[1] > 1000) == red,
                 'a log line with blue {} and red {}'.format(blue, red))

    def test_blue_red_and_nothing(self):
        self._wait_areas(False, True)
        self._wait_areas(False, False)
        # where it got to meanwhile, perhaps against the wall, depends on how busy the machine is
        rospy.ServiceProxy('/gazebo/reset_world', Empty)()
        for blue, red, direction in ((True, False, 1), (False, True, -1)):
            self._wait_areas(blue, red)
            start = self.odometry.messages[-1].pose.pose.position
            wait_for(lambda: self._speed() * direction > 0.3, 'driving, direction %d' % direction)
            self._wait_areas(False, False)
            wait_for(lambda: abs(self._speed()) < 0.002, 'standing after %d' % direction)
            self.assertEqual((0, 0), self._areas(), 'it came to rest before the next card')
            end = self.odometry.messages[-1].pose.pose.position
            self.assertGreater((end.x - start.x) * direction, 0.5)
            self.assertLess(abs(end.y - start.y), 0.5)

    def test_areas_are_logged_by_color_extract(self):
        self.log.wait()
        self.assertEqual('/color_extract', self.log.messages[-1].name)
        self.assertEqual(Log.INFO, self.log.messages[-1].level)
        self.assertRegex(self.log.messages[-1].msg, r'^blue=\d+, red=\d+$')


if __name__ == '__main__':
    rospy.init_node('drive_test')
    rostest.rosrun('img_recog', 'drive', DriveTest)
