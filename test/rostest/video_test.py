#!/usr/bin/env python3
"""A video of a street through camera and recognition, checked frame by frame.

The commands for each frame are compared in recorded_test.py.
"""
import hashlib
import unittest

import cv2
import cv_bridge
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog_helpers import plain_opencv
from img_recog_helpers.recording import main, wait_for
from img_recog_helpers.videos import opencv_frames

FRAMES = 250


def digest(data):
    return hashlib.sha256(data).hexdigest()


def read_video(path):
    """Return for each frame: digest of its rgb8 bytes; of both colors: areas, digests, lit px."""
    frames = []
    for rgb in opencv_frames(path):
        areas, masked = zip(*plain_opencv.results(rgb[..., ::-1].copy()))
        frames.append((digest(rgb.tobytes()), *areas,
                       *(digest(image.tobytes()) for image in masked), *map(lit_px, masked)))
    return frames


def lit_px(image):
    """Return how many pixels of an image are not black."""
    first, second, third = cv2.split(image)
    return cv2.countNonZero(first | second | third)


class VideoTest(unittest.TestCase):
    """Plays the video a little more than once and compares all images."""

    @classmethod
    def setUpClass(cls):
        cls.video = read_video(rospy.get_param('~video'))
        # stores only digests: the frames of the video would take 130 MB
        cls.raw, cls.blue, cls.red = {}, {}, {}
        for topic, stored in (('/usb_cam/image_raw', cls.raw), ('/blue_image', cls.blue),
                              ('/red_image', cls.red)):
            rospy.Subscriber(topic, Image, cls._store, stored, queue_size=100, buff_size=1 << 26)
        cls.png = {}
        compressed = rospy.Subscriber('/usb_cam/image_raw/compressed', CompressedImage,
                                      cls._store_png, queue_size=100, buff_size=1 << 26)
        # a busy machine drops frames, and of each topic others
        wait_for(lambda: len(set(cls.png) & set(cls.raw)) > 0.5 * FRAMES, 'frames of both', 120)
        compressed.unregister()         # to compress takes more time than all else
        # a busy machine drops frames: the video then plays until most of them have come once
        wait_for(lambda: len(cls.raw) > FRAMES + 60 and len(cls._digests()) > 0.9 * FRAMES,
                 'the video to run through', 120)

    @classmethod
    def _digests(cls):
        return {entry[1] for entry in list(cls.raw.values())}

    @staticmethod
    def _store(msg, stored):
        stored[msg.header.stamp] = (len(stored), digest(msg.data), msg.encoding)

    @classmethod
    def _store_png(cls, msg):
        cls.png[msg.header.stamp] = (msg.format, digest(cv2.cvtColor(
            cv_bridge.CvBridge().compressed_imgmsg_to_cv2(msg), cv2.COLOR_BGR2RGB).tobytes()))

    def test_frames_compressed_as_png_are_the_same(self):
        for stamp in set(self.png) & set(self.raw):
            self.assertEqual('rgb8; png compressed bgr8', self.png[stamp][0])
            self.assertEqual(self.raw[stamp][1], self.png[stamp][1])

    def test_the_video_is_the_one_expected(self):
        self.assertEqual(FRAMES, len(self.video))
        _, blue, red, _, _, lit_blue, lit_red = zip(*self.video)
        self.assertEqual((1085, 1734), (max(blue), max(red)))
        # no pixel inside a range is black: V is at least 100
        self.assertEqual((blue, red), (lit_blue, lit_red))

    def test_frames_arrive_in_order_bit_for_bit_and_loop(self):
        number = {frame[0]: index for index, frame in enumerate(self.video)}
        self.assertEqual(FRAMES, len(number), 'all frames have different bytes')
        seen = [number[entry[1]] for entry in sorted(self.raw.values())]
        steps = {(b - a) % FRAMES for a, b in zip(seen, seen[1:])}
        # one that goes back by a few has a step of nearly all frames
        self.assertLess(max(steps), 0.8 * FRAMES,
                        'a busy machine may drop frames, but not go back')
        self.assertNotIn(0, steps)
        # the frames that were dropped come in a later round
        digests = {frame[0] for frame in self.video}
        wait_for(lambda: self._digests() == digests, 'each frame of the video')

    def test_masked_images_frame_by_frame(self):
        by_digest = {frame[0]: frame for frame in self.video}
        for stored, column in ((self.blue, 3), (self.red, 4)):
            wait_for(lambda: len(set(stored) & set(self.raw)) > 0.8 * FRAMES, 'frames of both')
            for stamp in set(stored) & set(self.raw):
                frame = by_digest[self.raw[stamp][1]]
                self.assertEqual(frame[column], stored[stamp][1])
                self.assertEqual('bgr8', stored[stamp][2])


if __name__ == '__main__':
    main(VideoTest)
