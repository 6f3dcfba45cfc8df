#!/usr/bin/env python3
"""A bag is played into color_extract: its commands are those that were recorded, one by one.

The bag is written first: images, and the commands for them by plain OpenCV. `rosbag play` sends
the next image when the node has processed the last one, so that no load of the machine makes the
node drop an image.
"""
import os
import subprocess
import tempfile
import unittest

import numpy as np
import rosbag
import rospy
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import PointCloud

from img_recog_helpers import plain_opencv
from img_recog_helpers.frames import message, picture
from img_recog_helpers.recording import Diagnostics, Recorder, main, wait_for

IMAGES, COMMANDS = '/usb_cam/image_raw', '/recorded/cmd_vel'
RATE_HZ = 30.0
START_S = 1000.0
# pixels of blue and red around the limit, which must be exceeded
AREAS = [(blue, red) for blue in (0, 1000, 1001, 5000) for red in (0, 1000, 1001)]


def pictures():
    """Return bgr8 images: known areas, and noise in which the colors are at their limits."""
    found = [picture(blue, red, (160, 120)) for blue, red in AREAS]
    for seed, (height, width) in enumerate([(120, 160), (97, 131), (240, 320), (61, 64)] * 2):
        rng = np.random.RandomState(seed)
        image = rng.randint(0, 256, (height, width, 3)).astype(np.uint8)
        image[:rng.randint(0, height)] = rng.randint(0, 256, 3)     # blue, red or another color
        found.append(image)
    return found


def write_bag(path):
    """Write a bag with images and their commands; return the number of images."""
    with rosbag.Bag(path, 'w') as bag:
        images = pictures()
        for number, image in enumerate(images):
            stamp = rospy.Time.from_sec(START_S + number / RATE_HZ)
            encoding, pixels = (('bgr8', image), ('rgb8', image[..., ::-1]))[number % 2]
            bag.write(IMAGES, message(pixels, encoding, stamp=stamp), stamp)
            for speed in plain_opencv.commands(image):
                bag.write(COMMANDS, Twist(linear=Vector3(x=speed)), stamp)
    return len(images)


def values(twist):
    """Return all values of a Twist; the classes of a bag's messages are others."""
    return [getattr(getattr(twist, part), axis) for part in ('linear', 'angular')
            for axis in 'xyz']


class RecordedTest(unittest.TestCase):
    """Compares the commands with those in the bag."""

    def test_the_commands_are_the_recorded_ones(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'recorded.bag')
            count = write_bag(path)
            with rosbag.Bag(path) as bag:
                stamps = [msg.header.stamp for _, msg, _ in bag.read_messages([IMAGES])]
                recorded = [msg for _, msg, _ in bag.read_messages([COMMANDS])]
            twists, details = Recorder('/cmd_vel', Twist), Recorder('/color_detection', PointCloud)
            states = Diagnostics()
            wait_for(lambda: all(each.get_num_connections() for each in (twists, details, states)),
                     'color_extract')
            self._play(path, stamps, details)
        self.assertEqual(count, len(stamps))
        self.assertGreater(len({tuple(plain_opencv.commands(image)) for image in pictures()}), 3)
        wait_for(lambda: len(twists.messages) >= len(recorded), 'the last command')
        # the counters of the node say that there was nothing else
        wait_for(lambda: self._counters(states) == (count, count, 0, 0, len(recorded)),
                 lambda: '{}, not {}'.format(len(recorded), self._counters(states)))
        self.assertEqual([values(msg) for msg in recorded],
                         [values(msg) for msg in twists.messages])
        self.assertEqual(stamps, [msg.header.stamp for msg in details.messages])
        self.assertEqual([plain_opencv.areas_px(image) for image in pictures()],
                         [[msg.channels[number].values[number] for number in range(2)]
                          for msg in details.messages])

    def _play(self, path, stamps, details):
        """Play the images, each after the details of the last one have arrived."""
        command = ['rosbag', 'play', '--pause', '--quiet', '--wait-for-subscribers', path,
                   '--topics', IMAGES]
        with subprocess.Popen(command, stdin=subprocess.PIPE, bufsize=0) as play:
            for number, stamp in enumerate(stamps):
                play.stdin.write(b's')          # the next message
                wait_for(lambda: len(details.messages) > number,
                         'image {} at {}'.format(number, stamp.to_sec()))
        self.assertEqual(0, play.returncode)

    @staticmethod
    def _counters(states):
        """Return images received, processed, replaced and refused, and commands."""
        for values in states.values('color_extract: recognition')[-1:]:
            return tuple(int(values[key]) for key in (
                'images received', 'images processed', 'images replaced by newer ones',
                'images refused', 'commands'))
        return None


if __name__ == '__main__':
    main(RecordedTest)
