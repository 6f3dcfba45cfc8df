#!/usr/bin/env python3
"""The robot drives forward on blue, backward on red, and stands if neither is visible."""
import unittest

from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log

from img_recog_helpers.recording import AreaLines, Recorder, areas, call, main, wait_for


class DriveTest(unittest.TestCase):
    """Checks odometry and log while the synthetic camera shows all cards once."""

    @classmethod
    def setUpClass(cls):
        cls.odometry = Recorder('/odom', Odometry)
        cls.log = AreaLines()
        cls.odometry.wait()

    def setUp(self):
        self._next = 0          # log line from which on `_wait_areas` searches

    def _wait_areas(self, blue, red):
        """Return the time of the next log line that has these colors.

        A busy machine may run the test long after it.
        """
        def number():
            return next((number + 1 for number, msg in enumerate(self.log.messages)
                         if number >= self._next
                         and [area > 1000 for area in areas(msg)] == [blue, red]), None)
        self._next = wait_for(number, 'a log line with blue {} and red {}'.format(blue, red))
        return self.log.messages[self._next - 1].header.stamp

    def _wait_odometry(self, after, accept, what):
        """Return the first odometry after a time that `accept` returns True for."""
        return wait_for(lambda: next((
            msg for msg in self.odometry.messages if msg.header.stamp > after
            and accept(msg.twist.twist.linear.x)), None), what)

    def test_blue_red_and_nothing(self):
        self._wait_areas(False, True)
        self._wait_areas(False, False)
        # where it got to meanwhile, perhaps against the wall, depends on how busy the machine is
        call('/gazebo/reset_world')
        self._next = len(self.log.messages)
        self._wait_areas(False, False)
        for blue, red, direction in ((True, False, 1), (False, True, -1)):
            wait_for(lambda: self._drives_and_rests(blue, red, direction),
                     'the robot to come to rest before the next card')

    def _drives_and_rests(self, blue, red, direction):
        """Check a drive; return False if the next card came before its end: a busy machine."""
        begin = self._wait_areas(blue, red)
        start = self._wait_odometry(begin, lambda _: True, 'odometry').pose.pose.position
        self._wait_odometry(begin, lambda speed: speed * direction > 0.3,
                            'driving, direction %d' % direction)
        gone = self._wait_areas(False, False)
        # a busy machine simulates slowly, and the next card comes by wall time
        call('/usb_cam/stop_capture')
        at_rest = self._wait_odometry(gone, lambda speed: abs(speed) < 0.002,
                                      'standing after %d' % direction)
        is_alone = {(0, 0)} == {areas(msg) for msg in list(self.log.messages)
                                if gone <= msg.header.stamp <= at_rest.header.stamp}
        self._next = len(self.log.messages)
        # the camera begins with the blue card
        call('/gazebo/reset_world')
        call('/usb_cam/start_capture')
        if not is_alone:
            return False
        end = at_rest.pose.pose.position
        self.assertGreater((end.x - start.x) * direction, 0.2)
        # wheels that slip bend the way, as in Gazebo
        self.assertLess(abs(end.y - start.y), 1.5)
        return True

    def test_areas_are_logged_by_color_extract(self):
        self.log.wait()
        self.assertEqual('/color_extract', self.log.messages[-1].name)
        self.assertEqual(Log.INFO, self.log.messages[-1].level)
        self.assertRegex(self.log.messages[-1].msg, r'^blue=\d+, red=\d+$')


if __name__ == '__main__':
    main(DriveTest)
