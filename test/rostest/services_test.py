#!/usr/bin/env python3
"""The services of the simulator and the camera in the running demo."""
import os
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from sensor_msgs.srv import SetCameraInfo
from std_srvs.srv import Empty

from img_recog_testing.recording import Recorder, wait_for


def call(name):
    rospy.wait_for_service(name)
    return rospy.ServiceProxy(name, Empty)()


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
        cls.clock.wait()

    def test_pause_stops_the_clock_and_unpause_continues_it(self):
        call('/gazebo/pause_physics')
        self.images.wait(5)         # gives the last messages of the clock time to arrive
        before = len(self.clock.messages)
        self.images.wait(10)        # a third of a second of wall time
        self.assertEqual(before, len(self.clock.messages))
        paused = self.clock.messages[-1].clock.to_sec()
        call('/gazebo/unpause_physics')
        self.clock.wait(10)
        resumed = self.clock.messages[before].clock.to_sec()
        self.assertAlmostEqual(0.01, resumed - paused, 6)
        self._check_messages_within_a_second(self.clock.messages[before].clock)

    def _at_start(self, msg):
        position = msg.pose.pose.position
        return abs(position.x + 2.0) < 0.02 and abs(position.y + 0.5) < 0.02

    def _resting_at_start(self, msg):
        return self._at_start(msg) and abs(msg.twist.twist.linear.x) < 0.05

    def _reset(self, service):
        """Call a service; check at once that the robot is at its start, before it drives away."""
        before = len(self.odometry.messages)
        call(service)
        # up to ten messages from before may still be in a queue of plain rospy
        wait_for(lambda: any(map(self._resting_at_start,
                                 self.odometry.messages[before:before + 15])),
                 'the robot at rest at its start')

    def _check_messages_within_a_second(self, since):
        """Check that each topic has a message stamped within a simulated second after `since`."""
        for topic, recorder in self.sensors.items():
            wait_for(lambda: any(0 < (msg.header.stamp - since).to_sec() <= 1.0
                                 for msg in recorder.messages[-400:]), topic)

    def _wait_moved(self):
        wait_for(lambda: not self._at_start(self.odometry.messages[-1]), 'the robot to leave')

    def test_reset_world_resets_the_robot_and_not_the_time(self):
        self._wait_moved()
        before = self.clock.messages[-1].clock
        self._reset('/gazebo/reset_world')
        self.assertGreater(self.clock.messages[-1].clock, before)
        self._check_messages_within_a_second(self.clock.messages[-1].clock)

    def test_reset_simulation_resets_the_robot_and_the_time(self):
        self._wait_moved()
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() > 5.0, 'five simulated seconds')
        self._reset('/gazebo/reset_simulation')
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() < 4.0, 'the clock near zero')
        self._check_messages_within_a_second(rospy.Time())
        self.images.wait(5)
        self.assertLess(self.odometry.messages[-1].header.stamp.to_sec(), 60.0)

    def test_reset_simulation_while_paused_publishes_the_clock_at_once(self):
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() > 1.0, 'a simulated second')
        call('/gazebo/pause_physics')
        call('/gazebo/reset_simulation')
        wait_for(lambda: self.clock.messages[-1].clock.to_nsec() == 0, 'the clock at zero')
        call('/gazebo/unpause_physics')
        wait_for(lambda: self.clock.messages[-1].clock.to_sec() > 0.1, 'the clock to continue')
        self._check_messages_within_a_second(rospy.Time())

    def test_stop_and_start_capture(self):
        for _ in range(2):      # a second call has no effect
            call('/usb_cam/stop_capture')
        self.clock.wait(30)
        before = len(self.images.messages)
        self.clock.wait(50)
        self.assertEqual(before, len(self.images.messages))
        for _ in range(2):
            call('/usb_cam/start_capture')
        self.images.wait(5)

    def test_set_camera_info_is_published_and_written(self):
        given = CameraInfo(width=640, height=480, distortion_model='plumb_bob',
                           D=[0.1, -0.2, 0.0, 0.0, 0.01],
                           K=[500.0, 0, 320, 0, 510.0, 240, 0, 0, 1],
                           R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                           P=[500.0, 0, 320, 0, 0, 510.0, 240, 0, 0, 0, 1, 0])
        rospy.wait_for_service('/usb_cam/set_camera_info')
        answer = rospy.ServiceProxy('/usb_cam/set_camera_info', SetCameraInfo)(given)
        self.assertTrue(answer.success, answer.status_message)
        self.addCleanup(os.unlink, answer.status_message)
        wait_for(lambda: self.infos.messages[-1].K == tuple(given.K), 'the calibration')
        self.assertEqual(tuple(given.D), self.infos.messages[-1].D)
        self.assertEqual(tuple(given.P), self.infos.messages[-1].P)
        with open(answer.status_message) as file:
            self.assertIn('camera_matrix', file.read())
        given.width = 320
        refused = rospy.ServiceProxy('/usb_cam/set_camera_info', SetCameraInfo)(given)
        self.assertFalse(refused.success)
        self.assertIn('320x480, the images are 640x480', refused.status_message)


if __name__ == '__main__':
    rospy.init_node('services_test')
    rostest.rosrun('img_recog', 'services', ServicesTest)
