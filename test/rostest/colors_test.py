#!/usr/bin/env python3
"""Test frames through color_extract, and commands through the simulator.

The commands for frames are compared in recorded_test.py.
"""
import unittest

import cv2
import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image

from img_recog_helpers import plain_opencv
from img_recog_helpers.frames import message, picture
from img_recog_helpers.recording import AreaLines, Diagnostics, Recorder, call, main, wait_for


class ColorsTest(unittest.TestCase):
    """Publishes one frame at a time and waits for its result."""

    @classmethod
    def setUpClass(cls):
        cls.camera = rospy.Publisher('/usb_cam/image_raw', Image, queue_size=10)
        cls.drive = rospy.Publisher('/cmd_vel', Twist, queue_size=10)
        cls.images = {'blue': Recorder('/blue_image', Image), 'red': Recorder('/red_image', Image)}
        cls.areas = AreaLines()
        cls.warnings = Recorder('/rosout', Log, lambda msg: msg.level >= Log.WARN)
        cls.diagnostics = Diagnostics()
        cls.odometry = Recorder('/odom', Odometry)
        cls.odometry.wait()
        wait_for(lambda: cls.camera.get_num_connections() == 1, 'color_extract to subscribe')
        wait_for(cls.drive.get_num_connections, 'the simulator')
        cls.areas.wait_connected('/color_extract')
        cls.warnings.wait_connected('/color_extract', '/gazebo')

        def connected():
            cls._send(message(picture(), 'bgr8'))
            return all(each.messages for each in (cls.areas, *cls.images.values()))
        wait_for(connected, 'the outputs of color_extract')

    @classmethod
    def _send(cls, msg):
        """Publish a frame and wait until color_extract has logged its areas."""
        before = len(cls.areas.messages)
        cls.camera.publish(msg)
        wait_for(lambda: len(cls.areas.messages) > before, 'a log line')

    def setUp(self):
        """Wait until nothing of the test before moves the robot."""
        wait_for(lambda: all(abs(msg.twist.twist.linear.x) < 0.005
                             for msg in self.odometry.wait(10)[-10:]), 'the robot at rest')

    def test_every_encoding_bit_for_bit(self):
        rng = np.random.RandomState(1)
        bgr = rng.randint(0, 256, (240, 320, 3)).astype(np.uint8)
        grey = rng.randint(0, 256, (240, 320)).astype(np.uint8)
        alpha = rng.randint(0, 256, (240, 320, 1)).astype(np.uint8)
        bgra = np.concatenate([bgr, alpha], axis=2)
        cases = [(bgr, 'bgr8', bgr), (bgr[..., ::-1], 'rgb8', bgr), (bgra, 'bgra8', bgr),
                 (bgra[..., [2, 1, 0, 3]], 'rgba8', bgr),
                 (grey, 'mono8', cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR))]
        for sent, encoding, decoded in cases:
            for padding in (0, 13):
                self._check_images(message(np.ascontiguousarray(sent), encoding, padding), decoded)

    def _check_images(self, msg, bgr):
        before = {name: len(each.messages) for name, each in self.images.items()}
        self._send(msg)
        want = dict(zip(('blue', 'red'), plain_opencv.results(bgr)))
        self.assertEqual('blue={}, red={}'.format(want['blue'][0], want['red'][0]),
                         self.areas.messages[-1].msg, msg.encoding)
        for name, recorder in self.images.items():
            # an image of a frame before may arrive late
            wait_for(lambda: len(recorder.messages) > before[name] and
                     recorder.messages[-1].header.stamp == msg.header.stamp, name + '_image')
            got = recorder.messages[-1]
            self.assertEqual(('bgr8', 320, 240, 960, 'test_camera'),
                             (got.encoding, got.width, got.height, got.step,
                              got.header.frame_id))
            self.assertEqual(msg.header.stamp, got.header.stamp)
            self.assertEqual(want[name][1].tobytes(), got.data, (msg.encoding, name))

    def _wait_warning(self, *words):
        def warned():
            return [msg for msg in self.warnings.messages if all(w in msg.msg for w in words)]
        found = wait_for(lambda: warned(), 'a warning with {}'.format(words))
        self.assertNotIn('\n', found[0].msg)

    def test_bad_frames_are_skipped_with_a_warning(self):
        good = picture()
        bad = [message(good, 'no_such_encoding'), message(good, 'bgr8'), message(good, 'bgr8'),
               message(good, 'bgr8')]
        bad[1].data = bad[1].data[:1000]
        bad[2].step = 1
        bad[3].width = bad[3].height = 0
        for msg in bad:
            self.camera.publish(msg)
        self._wait_warning('frame skipped')
        self._check_images(message(picture(5000, 3000), 'bgr8'), picture(5000, 3000))

        def is_complete(values):
            received, *rest = (int(values['images ' + key]) for key in (
                'received', 'processed', 'refused', 'replaced by newer ones'))
            return received == sum(rest) and rest[1] > 0
        values = self.diagnostics.wait_values('color_extract: recognition', is_complete)
        self.assertRegex(values['last reason'], 'image')

    def test_nan_and_infinite_twists_are_ignored(self):
        self.drive.publish(Twist())
        for value in (float('nan'), float('inf'), -float('inf')):
            twist = Twist()
            twist.linear.x = value
            self.drive.publish(twist)
        twist = Twist()
        twist.angular.z = float('nan')
        self.drive.publish(twist)
        self._wait_warning('ignored a message on cmd_vel', 'nan')
        values = self.diagnostics.wait_values('gazebo: simulation',
                                              lambda values: values['commands refused'] == '4')
        self.assertIn('nan', values['last reason'])
        # a valid command afterwards is executed, until its timeout
        twist, before = Twist(), len(self.odometry.messages)
        twist.linear.x = 0.2
        self.drive.publish(twist)
        wait_for(lambda: any(abs(msg.twist.twist.linear.x - 0.2) < 0.02
                             for msg in self.odometry.messages[before:]), 'the robot at 0.2 m/s')
        self.drive.publish(Twist())
        wait_for(lambda: abs(self.odometry.messages[-1].twist.twist.linear.x) < 0.005,
                 'the robot at rest')

    def test_command_from_before_a_reset_is_discarded(self):
        def received():
            """Return how many commands the simulator has, as of its next status."""
            return int(self.diagnostics.wait_values('gazebo: simulation', is_new=True)['commands'])
        call('/gazebo/pause_physics')
        twist, before = Twist(), received()
        twist.linear.x = 0.5
        self.drive.publish(twist)
        wait_for(lambda: received() > before, 'the command')
        call('/gazebo/reset_world')
        call('/gazebo/unpause_physics')
        before = len(self.odometry.messages)
        self.odometry.wait(30)
        self.assertLess(max(abs(msg.twist.twist.linear.x)
                            for msg in self.odometry.messages[before:]), 0.01)


if __name__ == '__main__':
    main(ColorsTest)
