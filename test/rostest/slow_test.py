#!/usr/bin/env python3
"""A color_extract six times slower than its camera drops frames and processes the newest."""
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from sensor_msgs.msg import CameraInfo, Image

from img_recog_helpers import statuses
from img_recog_helpers.recording import Recorder, call, main, wait_for

MAX_AGE_S = 0.4         # of the newest; on a busy machine some wait for a processor
FRAMES = 60


class SlowTest(unittest.TestCase):
    """The synthetic camera at 30 Hz."""

    def test_frames_are_not_older_than_400_ms_when_their_results_arrive(self):
        ages, frames = [], Recorder('/usb_cam/camera_info', CameraInfo)
        frames.wait()

        def store_age(msg):
            ages.append((rospy.Time.now() - msg.header.stamp).to_sec())
        rospy.Subscriber('/blue_image', Image, store_age, buff_size=1 << 24, tcp_nodelay=True)
        wait_for(lambda: len(ages) > FRAMES, 'images of blue')
        # with a queue they would be older and older, at the end 10 s
        self.assertLess(min(ages[-FRAMES // 3:]), MAX_AGE_S)
        self.assertGreater(min(ages), 0.2)
        # most frames were dropped; the camera of a busy machine has fewer
        self.assertGreater(len(frames.messages), 2 * len(ages))

    def test_it_says_that_it_is_too_slow(self):
        def status_of(msg):
            return next((status for status in msg.status
                         if status.name == 'color_extract: recognition'), None)

        def is_full(msg):
            # the test before stopped the camera: a period may be without an image, and then
            # without a latency
            status = status_of(msg)
            return (status is not None and status.level == DiagnosticStatus.WARN
                    and 'too slow' in status.message
                    and statuses.values(status)['stamp to commands, max (ms)'] != 'none')
        states = Recorder('/diagnostics', DiagnosticArray, is_full)
        states.wait(2)      # the second one counts a whole period
        values = statuses.values(status_of(states.messages[1]))
        self.assertLess(float(values['images processed (Hz)']), 6)
        self.assertGreater(int(values['images replaced by newer ones']), 4)
        self.assertGreater(float(values['stamp to commands, max (ms)']), 200)

    def test_at_most_three_more_commands_after_the_input_ends(self):
        # of the frame that is processed, of the newest one, and one that was on its way
        twists = Recorder('/cmd_vel', Twist)
        # with each frame; so that this process is not late, it does not get the images
        frames = Recorder('/usb_cam/camera_info', CameraInfo)
        twists.wait(2)
        frames.wait(2)
        self.addCleanup(call, '/usb_cam/start_capture')
        call('/usb_cam/stop_capture')
        before, last = len(twists.messages), len(frames.messages)
        # the last two frames take 0.5 s; wait for five times as long
        end = rospy.Time.now() + rospy.Duration(2.5)
        wait_for(lambda: rospy.Time.now() > end, 'the time to pass')
        self.assertLessEqual(len(frames.messages), last + 3)
        self.assertLessEqual(len(twists.messages) - before, 3)


if __name__ == '__main__':
    main(SlowTest)
