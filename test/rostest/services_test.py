#!/usr/bin/env python3
"""The services of the simulator and the camera in the running demo."""
import os
import unittest

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from sensor_msgs.srv import SetCameraInfo

from img_recog_helpers.recording import Recorder, call, main, wait_for


class ServicesTest(unittest.TestCase):
    """Each test leaves the system running."""

    @classmethod
    def setUpClass(cls):
        cls.clock = Recorder('/clock', Clock)
        cls.odometry = Recorder('/odom', Odometry)
        cls.joints = Recorder('/joint_states', JointState)
        cls.images = Recorder('/usb_cam/image_raw', Image)
        cls.sensors = {'/odom': cls.odometry, '/joint_states': cls.joints,
                       '/imu': Recorder('/imu', Imu), '/scan': Recorder('/scan', LaserScan)}
        cls.infos = Recorder('/usb_cam/camera_info', CameraInfo)
        for recorder in (cls.clock, cls.images, cls.infos, *cls.sensors.values()):
            recorder.wait()

    def _wait_silent(self, recorder, other, count):
        """Wait until a topic has no message while another one has `count`.

        The last messages may arrive late.
        """
        def is_silent():
            before = len(recorder.messages)
            other.wait(count)
            return len(recorder.messages) == before
        wait_for(is_silent, 'the end of the messages')

    def test_pause_stops_the_clock_and_unpause_continues_it(self):
        call('/gazebo/pause_physics')
        self._wait_silent(self.clock, self.images, 10)      # a third of a second of wall time
        before, counts = len(self.clock.messages), self._counts()
        paused = self.clock.messages[-1].clock.to_sec()
        call('/gazebo/unpause_physics')
        self.clock.wait(10)
        resumed = self.clock.messages[before].clock.to_sec()
        self.assertAlmostEqual(0.01, resumed - paused, 6)
        self._check_messages_within_a_second(self.clock.messages[before].clock, counts)

    def _at_start(self, msg):
        position = msg.pose.pose.position
        return abs(position.x + 2.0) < 0.02 and abs(position.y + 0.5) < 0.02

    def _reset(self, service):
        """Call a service; check that it moves the robot to its start. Return that odometry.

        The camera stops meanwhile, or the robot could drive to its start, or from it, by itself.
        """
        wait_for(lambda: not self._at_start(self.odometry.messages[-1]) and self._stands(),
                 'the robot at rest away from its start')
        call('/usb_cam/stop_capture')
        try:
            self._wait_silent(self.images, self.odometry, 30)
            wait_for(self._stands, 'the robot at rest')
            self.assertFalse(self._at_start(self.odometry.messages[-1]))
            before = len(self.odometry.messages)
            call(service)
            wait_for(lambda: self._at_start(self.odometry.messages[-1]) and self._stands(),
                     'the robot at rest at its start')
            return next(msg for msg in self.odometry.messages[before:] if self._at_start(msg))
        finally:
            call('/usb_cam/start_capture')

    def _stands(self):
        return abs(self.odometry.messages[-1].twist.twist.linear.x) < 0.002

    def _counts(self):
        """Return how many messages each sensor has."""
        return {topic: len(recorder.messages) for topic, recorder in self.sensors.items()}

    def _check_messages_within_a_second(self, since, counts):
        """Check that each topic has a message stamped within a simulated second after `since`.

        counts: as from `_counts`, before the service was called.
        """
        for topic, recorder in self.sensors.items():
            wait_for(lambda: any(0 < (msg.header.stamp - since).to_sec() <= 1.0
                                 for msg in recorder.messages[counts[topic]:]), topic)

    def test_reset_world_resets_the_robot_and_not_the_time(self):
        before, counts, clocks = self.odometry.messages[-1], self._counts(), len(
            self.clock.messages)
        reset = self._reset('/gazebo/reset_world')
        self.assertGreater(reset.header.stamp, before.header.stamp)
        self._check_messages_within_a_second(reset.header.stamp, counts)
        times = [msg.clock for msg in self.clock.messages[clocks:]]
        self.assertEqual(sorted(times), times)

    def test_reset_simulation_resets_the_robot_and_the_time(self):
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() > 5.0, 'five simulated seconds')
        counts, clocks = self._counts(), len(self.clock.messages)
        reset = self._reset('/gazebo/reset_simulation')
        self.assertLess(reset.header.stamp.to_sec(), 1.0)
        wait_for(lambda: any(msg.clock.to_sec() < 1.0 for msg in self.clock.messages[clocks:]),
                 'the clock near zero')
        self._check_messages_within_a_second(rospy.Time(), counts)
        self.images.wait(5)
        self.assertLess(self.odometry.messages[-1].header.stamp.to_sec(), 60.0)

    def test_reset_simulation_while_paused_publishes_the_clock_at_once(self):
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() > 1.0, 'a simulated second')
        counts = self._counts()
        call('/gazebo/pause_physics')
        call('/gazebo/reset_simulation')
        wait_for(lambda: self.clock.messages[-1].clock.to_nsec() == 0, 'the clock at zero')
        call('/gazebo/unpause_physics')
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() > 0.1, 'the clock to continue')
        self._check_messages_within_a_second(rospy.Time(), counts)

    def test_stop_and_start_capture(self):
        for _ in range(2):      # a second call has no effect
            call('/usb_cam/stop_capture')
        self._wait_silent(self.images, self.clock, 50)
        for _ in range(2):
            call('/usb_cam/start_capture')
        self.images.wait(5)

    def test_set_camera_info_is_published_and_written(self):
        given = CameraInfo(width=640, height=480, distortion_model='plumb_bob',
                           D=[0.1, -0.2, 0.0, 0.0, 0.01],
                           K=[500.0, 0, 320, 0, 510.0, 240, 0, 0, 1],
                           R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                           P=[500.0, 0, 320, 0, 0, 510.0, 240, 0, 0, 0, 1, 0])
        answer = call('/usb_cam/set_camera_info', SetCameraInfo, given)
        self.assertTrue(answer.success, answer.status_message)
        self.addCleanup(os.unlink, answer.status_message)
        wait_for(lambda: self.infos.messages[-1].K == tuple(given.K), 'the calibration')
        self.assertEqual(tuple(given.D), self.infos.messages[-1].D)
        self.assertEqual(tuple(given.P), self.infos.messages[-1].P)
        with open(answer.status_message) as file:
            self.assertIn('camera_matrix', file.read())
        given.width = 320
        refused = call('/usb_cam/set_camera_info', SetCameraInfo, given)
        self.assertFalse(refused.success)
        self.assertIn('320x480, the images are 640x480', refused.status_message)


if __name__ == '__main__':
    main(ServicesTest)
