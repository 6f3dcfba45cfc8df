#!/usr/bin/env python3
"""Headers, encodings and values of the demo's messages."""
import itertools
import unittest

import numpy as np
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, LaserScan
from tf2_msgs.msg import TFMessage

from img_recog_helpers.recording import Recorder, from_node, main, wait_for


class FramesTest(unittest.TestCase):
    """Collects the messages of all topics and checks them."""

    @classmethod
    def setUpClass(cls):
        types = {'/usb_cam/image_raw': Image, '/usb_cam/camera_info': CameraInfo,
                 '/odom': Odometry, '/joint_states': JointState, '/imu': Imu, '/scan': LaserScan,
                 '/clock': Clock, '/tf': TFMessage}
        cls.topics = {name: Recorder(name, message_type) for name, message_type in types.items()}
        cls.idle = Recorder('/cmd_vel', Twist, from_node('/turtlebot3_teleop_keyboard'))
        for name, recorder in cls.topics.items():       # all arrive at the same time
            wait_for(lambda: len(recorder.messages) >= (10 if name == '/scan' else 60), name)

    def test_image_and_camera_info_have_the_same_headers(self):
        def pairs():
            infos = {msg.header.stamp: msg
                     for msg in list(self.topics['/usb_cam/camera_info'].messages)}
            return [(msg, infos[msg.header.stamp])
                    for msg in list(self.topics['/usb_cam/image_raw'].messages)
                    if msg.header.stamp in infos]
        # a busy machine drops messages, and of each topic others
        wait_for(lambda: len(pairs()) > 40, '40 images with their camera_info')
        for image in list(self.topics['/usb_cam/image_raw'].messages):
            self.assertEqual(('head_camera', 'rgb8', 640, 480, 1920),
                             (image.header.frame_id, image.encoding, image.width, image.height,
                              image.step))
        for _, info in pairs():
            self.assertEqual(('head_camera', 640, 480),
                             (info.header.frame_id, info.width, info.height))

    def test_stamps_are_simulated_time(self):
        def stamp(name):
            return self.topics[name].messages[-1].header.stamp.to_sec()
        for name in ('/usb_cam/image_raw', '/odom', '/joint_states'):
            # on a busy machine, images arrive late for a while
            wait_for(lambda: abs(stamp(name) - self.topics['/clock'].messages[-1].clock.to_sec())
                     < 5.0, 'stamps of simulated time on ' + name)
            self.assertGreater(stamp(name), 0.0, name)

    def test_odometry(self):
        for msg in list(self.topics['/odom'].messages):
            self.assertEqual(('odom', 'base_footprint'), (msg.header.frame_id, msg.child_frame_id))

    def test_tf_has_one_parent_for_each_frame_and_no_stamp_twice(self):
        def transforms():
            return [each for msg in list(self.topics['/tf'].messages) for each in msg.transforms]

        def parents():
            return {(each.child_frame_id, each.header.frame_id) for each in transforms()}
        expected = {('base_footprint', 'odom'), ('wheel_left_link', 'base_link'),
                    ('wheel_right_link', 'base_link')}
        # one of the two publishers may start later
        wait_for(lambda: parents() >= expected, lambda: 'the frames {}'.format(parents()))
        self.assertEqual(expected, parents())
        stamped = [(each.child_frame_id, each.header.stamp) for each in transforms()]
        self.assertEqual(len(set(stamped)), len(stamped))

    def test_joint_states(self):
        for msg in list(self.topics['/joint_states'].messages):
            # the order of libgazebo_ros_diff_drive
            self.assertEqual(['wheel_right_joint', 'wheel_left_joint'], msg.name)
            self.assertEqual([2, 2, 2], [len(msg.position), len(msg.velocity), len(msg.effort)])

    def test_scan(self):
        for msg in list(self.topics['/scan'].messages):
            self.assertEqual(('base_scan', 360), (msg.header.frame_id, len(msg.ranges)))
            self.assertAlmostEqual(6.28319, msg.angle_min + 359 * msg.angle_increment, 4)
            self.assertAlmostEqual(0.12, msg.range_min, 6)
            self.assertEqual(3.5, msg.range_max)
            ranges = np.array(msg.ranges)
            self.assertGreater(np.isfinite(ranges).sum(), 100)
            seen = ranges[np.isfinite(ranges)]
            self.assertTrue(np.all((seen >= msg.range_min) & (seen <= msg.range_max)))
            self.assertTrue(np.all(np.isposinf(ranges[~np.isfinite(ranges)])))

    def test_imu(self):
        messages = list(self.topics['/imu'].messages)
        for msg in messages:
            self.assertEqual('imu_link', msg.header.frame_id)
            self.assertAlmostEqual(4e-8, msg.angular_velocity_covariance[0])
            self.assertAlmostEqual(2.89e-4, msg.linear_acceleration_covariance[0])
        self.assertAlmostEqual(9.8, np.mean([msg.linear_acceleration.z for msg in messages]), 0)

    def test_periods_in_simulated_time(self):
        periods_ms = {'/odom': 33, '/joint_states': 33, '/imu': 5, '/scan': 200, '/clock': 10}
        for name, milliseconds in periods_ms.items():
            # a busy machine drops messages now and then, but a run of them comes complete
            wait_for(lambda: self._longest_run(name, milliseconds) >= 20,
                     lambda: '20 messages of {} in a row, {} came'.format(
                         name, self._longest_run(name, milliseconds)))
            periods = self._periods(name, milliseconds)
            # those between which others were dropped are whole multiples of the period
            self.assertEqual([round(period) for period in periods], periods, name)
            self.assertGreater(min(periods), 0, name)

    def _periods(self, name, milliseconds):
        times = [(msg.clock if name == '/clock' else msg.header.stamp).to_nsec()
                 for msg in list(self.topics[name].messages)]
        return [(b - a) / (milliseconds * 1e6) for a, b in zip(times, times[1:])]

    def _longest_run(self, name, milliseconds):
        return max((len(list(run)) for period, run in itertools.groupby(
            self._periods(name, milliseconds)) if period == 1), default=0)

    def test_idle_teleop_sends_zeros(self):
        wait_for(lambda: len(self.idle.messages) > 10, 'Twists of the idle teleop')
        for msg in list(self.idle.messages):
            self.assertEqual(Twist(), msg)


if __name__ == '__main__':
    main(FramesTest)
