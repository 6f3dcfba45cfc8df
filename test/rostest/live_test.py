#!/usr/bin/env python3
"""Settings that are changed while color_extract runs, and its additional topics."""
import itertools
import subprocess
import unittest

import cv2
import numpy as np
import rosnode
import rospy
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image, PointCloud

from img_recog_helpers.frames import BLUE, GREY, RED, message
from img_recog_helpers.recording import Recorder, from_node, main, wait_for
from img_recog_helpers.waiting import DEADLINE_S, stretch

NODE = '/color_extract'
YELLOW = (20, 180, 200)     # BGR
BLUE_HUE = 113
DEFAULTS = {'blue_hue_min': 50, 'blue_saturation_min': 100, 'blue_saturation_max': 255,
            'blue_area_limit': 1000, 'blue_linear_x': 10.0, 'red_hue_min': 150,
            'red_hue_max': 180, 'publish_commands': 'all', 'publish_on_change': False,
            'stop_when_lost': 0.0, 'roi_width': 0, 'min_blob_size': 0}


def picture(*squares):
    """Return a grey bgr8 picture of 320x240 with a square of 40x40 for each BGR color."""
    image = np.full((240, 320, 3), GREY, np.uint8)
    for number, bgr in enumerate(squares):
        image[100:140, 60 * number + 10:60 * number + 50] = bgr
    return image


class LiveTest(unittest.TestCase):
    """Publishes one frame at a time and waits for its result."""

    @classmethod
    def setUpClass(cls):
        cls.camera = rospy.Publisher('/usb_cam/image_raw', Image, queue_size=10)
        cls.twists = Recorder('/cmd_vel', Twist, from_node(NODE))
        cls.logs = Recorder('/rosout', Log, lambda msg: msg.name == NODE)
        cls.detections = Recorder('/color_detection', PointCloud)
        cls.overlays = Recorder('/color_overlay', Image)
        cls.yellow = Recorder('/yellow/masked', Image)
        cls.client = Client(NODE, timeout=DEADLINE_S * stretch())
        wait_for(lambda: cls.camera.get_num_connections() == 1, 'color_extract to subscribe')
        for recorder in (cls.logs, cls.twists):
            recorder.wait_connected(NODE)

        def connected():
            cls.send(picture())
            return all(each.messages for each in (cls.detections, cls.overlays, cls.yellow))
        wait_for(connected, 'the outputs of color_extract')
        cls.marks = itertools.count(1)

    def setUp(self):
        """Set the default values; wait for the commands and results of all earlier frames."""
        mark = next(self.marks) / 128
        self.client.update_configuration({**DEFAULTS, 'blue_linear_x': mark})
        before = message(picture(BLUE))
        self.send_message(before)
        wait_for(lambda: any(twist.linear.x == mark for twist in self.twists.messages),
                 'the command of this test')
        for recorder in (self.detections, self.overlays, self.yellow):
            self.result_of(before, recorder)
        self.client.update_configuration(DEFAULTS)

    @classmethod
    def result_of(cls, frame, recorder):
        """Return the message about a frame, by its stamp."""
        return wait_for(lambda: next((msg for msg in recorder.messages
                                      if msg.header.stamp == frame.header.stamp), None),
                        'the result of a frame')

    @classmethod
    def areas(cls):
        """Return the logged lines with areas."""
        return [msg.msg for msg in cls.logs.messages if msg.msg.startswith('blue=')]

    @classmethod
    def send(cls, image):
        """Publish a frame; return the line that is logged for it."""
        return cls.send_message(message(image))

    @classmethod
    def send_message(cls, msg):
        """Publish a frame; return the line that is logged for it."""
        before = len(cls.areas())
        cls.camera.publish(msg)
        wait_for(lambda: len(cls.areas()) > before, 'a log line')
        return cls.areas()[before]

    def commands_for(self, *images):
        """Return (linear.x, angular.z) of the commands for frames and for a red one after them."""
        before = len(self.twists.messages)
        for image in images:
            self.send(image)
        self.send(picture(RED))

        def sent():
            return [(twist.linear.x, twist.angular.z) for twist in self.twists.messages[before:]]
        wait_for(lambda: (-10.0, 0.0) in sent(), 'the command for red')
        return sent()

    def test_a_bound_set_by_dynparam_applies_from_the_next_frame_on(self):
        self.assertEqual('blue=1600, red=0, yellow=0', self.send(picture(BLUE)))
        for low, area_px in ((BLUE_HUE + 1, 0), (BLUE_HUE, 1600)):
            subprocess.run(['rosrun', 'dynamic_reconfigure', 'dynparam', 'set', NODE,
                            'blue_hue_min', str(low)], check=True)
            lines = [self.send(picture(BLUE)) for _ in range(2)]
            self.assertEqual('blue={}, red=0, yellow=0'.format(area_px), lines[1])
            self.assertEqual(low, rospy.get_param(NODE + '/blue_hue_min'))

    def test_a_third_color_has_a_command_and_an_image(self):
        image = picture(YELLOW, BLUE)
        before = len(self.yellow.messages)
        self.assertEqual([(10.0, 0.0), (0.0, 0.5), (-10.0, 0.0)], self.commands_for(image))
        wait_for(lambda: len(self.yellow.messages) > before, 'an image of yellow')
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        mask = cv2.inRange(hsv, np.array([20, 100, 100]), np.array([35, 255, 255]))
        self.assertEqual(1600, cv2.countNonZero(mask))
        self.assertEqual(cv2.bitwise_and(image, image, mask=mask).tobytes(),
                         self.yellow.messages[before].data)

    def test_detections_have_areas_and_centroids(self):
        frame = message(picture(BLUE, YELLOW))
        self.send_message(frame)
        msg = self.result_of(frame, self.detections)
        self.assertEqual('test_camera', msg.header.frame_id)
        self.assertEqual([('blue', (1600.0, 0.0, 0.0)), ('red', (0.0, 0.0, 0.0)),
                          ('yellow', (0.0, 0.0, 1600.0))],
                         [(channel.name, tuple(channel.values)) for channel in msg.channels])
        self.assertEqual([(29.5, 119.5), (89.5, 119.5)],
                         [(point.x, point.y) for point in (msg.points[0], msg.points[2])])
        self.assertTrue(np.isnan(msg.points[1].x) and np.isnan(msg.points[1].y))

    def test_the_overlay_shows_the_frame_with_an_outline(self):
        frame = message(picture(GREY, GREY, BLUE))
        self.send_message(frame)
        msg = self.result_of(frame, self.overlays)
        self.assertEqual(('bgr8', 320, 240, 'test_camera'),
                         (msg.encoding, msg.width, msg.height, msg.header.frame_id))
        drawn = np.frombuffer(msg.data, np.uint8).reshape(240, 320, 3)
        self.assertTrue((drawn[100, 130:170] != BLUE).any(axis=1).all())    # the outline
        self.assertTrue((drawn[104, 134:140] == BLUE).all())                # within
        self.assertTrue((drawn[200:, :] == GREY).all())

    def test_one_command_for_an_image_if_it_has_changed(self):
        self.client.update_configuration({'publish_commands': 'sum', 'publish_on_change': True})
        self.send(picture())
        self.assertEqual([(10.0, 0.0), (0.0, 0.0), (-10.0, 0.0)], self.commands_for(
            picture(BLUE), picture(BLUE), picture(BLUE, RED)))

    def test_zz_stop_when_the_image_is_stale_and_on_shutdown(self):
        self.send(picture())
        before = len(self.twists.messages)
        self.client.update_configuration({'stop_when_lost': 0.3})
        wait_for(lambda: len(self.twists.messages) > before, 'the stop')
        self.assertEqual(Twist(), self.twists.messages[-1])
        self.send(picture(BLUE))
        wait_for(lambda: self.twists.messages[-2:] and self.twists.messages[-2].linear.x == 10.0,
                 'the command for blue and the stop')
        self.assertEqual(Twist(), self.twists.messages[-1])
        self.client.update_configuration({'stop_when_lost': 1000.0})
        self.send(picture(BLUE))
        wait_for(lambda: self.twists.messages[-1].linear.x == 10.0, 'the command for blue')
        # the name makes this the last test: it ends the node
        rosnode.kill_nodes([NODE])
        wait_for(lambda: self.twists.messages[-1] == Twist(), 'the stop at the end')

    def test_log_messages_have_file_function_and_topics(self):
        self.send(picture())
        msg = next(msg for msg in self.logs.messages if msg.msg.startswith('blue='))
        self.assertEqual((Log.INFO, 'color_extract_node.py', 'ColorExtract.handle'),
                         (msg.level, msg.file, msg.function))
        self.assertIn('/cmd_vel', msg.topics)


if __name__ == '__main__':
    main(LiveTest)
