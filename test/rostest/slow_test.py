#!/usr/bin/env python3
"""A recognition that is six times slower than its camera acts on what is new."""
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image
from std_srvs.srv import Empty

from img_recog_testing.recording import Recorder, wait_for

OLDEST_S = 0.4
FRAMES = 60


class SlowTest(unittest.TestCase):
    """The synthetic scene at 30 Hz."""

    def test_no_frame_is_older_than_400_ms_when_it_is_acted_on(self):
        ages, frames = [], Recorder('/usb_cam/image_raw', Image)

        def take(msg):
            ages.append((rospy.Time.now() - msg.header.stamp).to_sec())
        rospy.Subscriber('/blue_image', Image, take, buff_size=1 << 24, tcp_nodelay=True)
        wait_for(lambda: len(ages) > FRAMES, 'images of blue')
        self.assertLess(max(ages), OLDEST_S)
        self.assertGreater(min(ages), 0.2)
        self.assertGreater(len(frames.messages), 4 * len(ages))     # most frames were left out

    def test_two_more_commands_at_most_after_the_input_ends(self):
        twists, frames = Recorder('/cmd_vel', Twist), Recorder('/usb_cam/image_raw', Image)
        rospy.wait_for_service('/usb_cam/stop_capture')
        stop = rospy.ServiceProxy('/usb_cam/stop_capture', Empty)
        twists.wait(2)
        stop()
        before, last = len(twists.messages), len(frames.messages)
        # two frames that were on their way take 0.5 s; wait for five times as long
        end = rospy.Time.now() + rospy.Duration(2.5)
        wait_for(lambda: rospy.Time.now() > end, 'the time to pass')
        self.assertLessEqual(len(frames.messages), last + 1)
        self.assertLessEqual(len(twists.messages) - before, 2)


if __name__ == '__main__':
    rospy.init_node('slow_test')
    rostest.rosrun('img_recog', 'slow', SlowTest)
