#!/usr/bin/env python3
"""A camera on the robot and the article's colors: towards blue until it leaves the picture."""
import math
import unittest

import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo, Image

from img_recog_helpers.driven import START, Robot, place
from img_recog_helpers.recording import Recorder, from_node, main, wait_for

FOCAL_PX = 320 / math.tan(math.radians(62.2) / 2)


class PostsBlueTest(unittest.TestCase):
    """The robot starts with a blue post ahead, a little to the left."""

    def test_towards_blue_until_it_is_out_of_the_picture(self):
        robot = Robot()
        robot.begin_again()
        # out of the picture, not just between two images of a slow camera
        wait_for(lambda: place(robot.odometry.messages[-1])[0] > START[0] + 0.5
                 and robot.areas('blue')[-1][1] == 0 and robot.rests(1),
                 lambda: 'the robot at rest: {}'.format(place(robot.odometry.messages[-1])))
        areas = robot.areas('blue')
        seen = [area for _, area in areas if area > 1000]
        self.assertGreater(len(seen), 5)
        self.assertLess(seen[0], 2500)
        self.assertGreater(max(seen), 2.5 * seen[0])
        self.assertEqual(0, areas[-1][1])
        self.assertEqual({10.0}, {msg.linear.x for msg in robot.commands.messages})
        self.assertEqual({0.0}, {msg.angular.z for msg in robot.commands.messages})
        # beside the post at 0.5, -0.15 it is out of the picture; then no command comes, and after
        # half a second the simulator brakes the robot from 2.2 m/s by 1 m/s^2; wheels that slip
        # bend the way, as in Gazebo
        last_s = max(stamp_s for stamp_s, area in areas if area > 1000)
        there = min(robot.odometry.messages,
                    key=lambda msg: abs(msg.header.stamp.to_sec() - last_s))
        self.assertTrue(-1.2 < place(there)[0] < 0.3, place(there))
        x, y = place(robot.odometry.messages[-1])
        self.assertTrue(place(there)[0] < x < 5.0 and abs(y - START[1]) < 4, (x, y))

    def test_the_topics_are_those_of_a_camera(self):
        images = Recorder('/usb_cam/image_raw', Image, from_node('/gazebo'))
        infos = Recorder('/usb_cam/camera_info', CameraInfo, from_node('/gazebo'))

        def common():
            stamps = {msg.header.stamp for msg in list(infos.messages)}
            return [msg for msg in list(images.messages) if msg.header.stamp in stamps]
        wait_for(lambda: len(common()) > 10, 'images and camera infos of equal stamps')
        images.close()
        infos.close()
        for image in common():
            self.assertEqual(('head_camera', 'rgb8', 640, 480, 1920),
                             (image.header.frame_id, image.encoding, image.width, image.height,
                              image.step))
        stamps = [msg.header.stamp.to_nsec() for msg in images.messages]
        self.assertEqual(sorted(set(stamps)), stamps)
        self.assertEqual({0}, {stamp % 33000000 for stamp in stamps})
        info = infos.messages[0]
        self.assertEqual(('head_camera', 640, 480, 'plumb_bob'),
                         (info.header.frame_id, info.width, info.height, info.distortion_model))
        for value, wanted in zip(info.K, (FOCAL_PX, 0, 320, 0, FOCAL_PX, 240, 0, 0, 1)):
            self.assertAlmostEqual(wanted, value, delta=0.6)

    def test_tf_from_the_robot_to_the_camera(self):
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        wait_for(lambda: buffer.can_transform('base_footprint', 'head_camera', rospy.Time()),
                 'tf from base_footprint to head_camera')
        found = buffer.lookup_transform('base_footprint', 'head_camera', rospy.Time()).transform
        for name, wanted in (('x', 0.033), ('y', 0.0), ('z', 0.163)):
            self.assertAlmostEqual(wanted, getattr(found.translation, name), places=6)
        sign = math.copysign(1.0, found.rotation.w)
        # x to the right, z forward
        for name, wanted in (('x', -0.5), ('y', 0.5), ('z', -0.5), ('w', 0.5)):
            self.assertAlmostEqual(wanted, sign * getattr(found.rotation, name), places=6)


if __name__ == '__main__':
    main(PostsBlueTest)
