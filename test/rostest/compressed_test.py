#!/usr/bin/env python3
"""Compressed images over real connections: published on demand and read by color_extract."""
import subprocess
import unittest
from unittest import mock

import numpy as np
import rospy
from cv_bridge import CvBridge
from dynamic_reconfigure.client import Client
from dynamic_reconfigure.msg import Config, ConfigDescription
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.nodes.compressed_images import CompressedImages
from img_recog_helpers import frames
from img_recog_helpers.recording import AreaLines, Recorder, from_node, main, wait_for
from img_recog_helpers.waiting import DEADLINE_S, stretch

NODES = ('color_extract', 'from_compressed')


def picture(blue_px=0, red_px=0, seed=1):
    """Return a noisy grey rgb8 picture with this number of pixels of each color."""
    return np.ascontiguousarray(frames.picture(blue_px, red_px, seed=seed)[..., ::-1])


def header():
    """Return a header with the current time."""
    return Header(stamp=rospy.Time.now(), frame_id='test_camera')


def dynparam(*words):
    """Run dynamic_reconfigure's dynparam; return its output."""
    return subprocess.run(['rosrun', 'dynamic_reconfigure', 'dynparam', *words], check=True,
                          stdout=subprocess.PIPE, timeout=DEADLINE_S * stretch()).stdout.decode()


class CompressedTest(unittest.TestCase):
    """Each test uses separate topics, except for those of the two color_extract nodes."""

    @classmethod
    def setUpClass(cls):
        cls.logs = Recorder('/rosout', Log)
        cls.logs.wait_connected(rospy.get_name(), *('/' + node for node in NODES))

    def _publisher(self, topic):
        publisher = CompressedImages(topic)
        self.addCleanup(publisher.close)
        return publisher

    def _get(self, publisher, recorder, image, encoding='rgb8'):
        """Publish until a message arrives; return the newest message."""
        before = len(recorder.messages)
        wait_for(lambda: publisher.publish(image, encoding, header()) or
                 len(recorder.messages) > before, 'a compressed image')
        return recorder.messages[-1]

    def _wait_log(self, level, *words):
        def logged():
            return [log.msg for log in self.logs.messages
                    if log.level == level and all(word in log.msg for word in words)]
        found = wait_for(logged, 'a log line with {}'.format(words))
        self.assertNotIn('\n', found[-1])

    def test_nothing_is_compressed_without_a_subscriber(self):
        real, done = compressed_image_msgs.to_msg, []

        def counted(image, encoding, head, settings):
            done.append(head.stamp)
            return real(image, encoding, head, settings)
        with mock.patch.object(compressed_image_msgs, 'to_msg', counted):
            publisher = self._publisher('/lonely/image_raw')
            for _ in range(20):
                publisher.publish(picture(), 'rgb8', header())
            first = rospy.Time.now()
            recorder = Recorder('/lonely/image_raw/compressed', CompressedImage)
            self._get(publisher, recorder, picture())
            self.assertGreaterEqual(min(done), first)
            recorder.close()
            wait_for(lambda: not publisher.is_wanted(), 'no subscriber')
            last = rospy.Time.now()
            for _ in range(20):
                publisher.publish(picture(), 'rgb8', header())
            recorder = Recorder('/lonely/image_raw/compressed', CompressedImage)
            again = rospy.Time.now()
            self._get(publisher, recorder, picture())
            self.assertEqual([], [stamp for stamp in done if last <= stamp < again])

    def test_cv_bridge_reads_the_messages(self):
        publisher = self._publisher('/small/image_raw')
        recorder = Recorder('/small/image_raw/compressed', CompressedImage)
        updates = Recorder('/small/image_raw/compressed/parameter_updates', Config)
        wait_for(publisher.is_wanted, 'a subscriber')
        sent = header()
        publisher.publish(picture(500, 700), 'rgb8', sent)
        wait_for(lambda: recorder.messages, 'a compressed image')
        msg, = recorder.messages
        # png and level 1 are set by parameters; the misspelt parameter is reported
        self.assertEqual('rgb8; png compressed bgr8', msg.format)
        self.assertEqual((sent.stamp, sent.frame_id), (msg.header.stamp, msg.header.frame_id))
        read = CvBridge().compressed_imgmsg_to_cv2(msg, 'rgb8')
        self.assertTrue(np.array_equal(picture(500, 700), read))
        wait_for(lambda: updates.messages, 'the parameters')
        self.assertIn(('png_level', 1),
                      [(each.name, each.value) for each in updates.messages[-1].ints])
        self._wait_log(Log.WARN, '/small/image_raw/compressed/jpeg_qualty',
                       'did you mean jpeg_quality?')
        publisher.publish(picture(), 'mono8', header())
        self._wait_log(Log.WARN, 'cannot compress', "encoding 'mono8' as png")

    def test_dynparam_changes_the_parameters_as_with_the_plugin(self):
        name = '/live/image_raw/compressed'
        publisher = self._publisher('/live/image_raw')
        recorder = Recorder(name, CompressedImage)
        updates = Recorder(name + '/parameter_updates', Config)
        descriptions = Recorder(name + '/parameter_descriptions', ConfigDescription)
        self.assertEqual('rgb8; jpeg compressed bgr8',
                         self._get(publisher, recorder, picture()).format)
        wait_for(lambda: descriptions.messages and updates.messages, 'the latched topics')
        group, = descriptions.messages[0].groups
        self.assertIn(('format', 'str'),
                      [(parameter.name, parameter.type) for parameter in group.parameters])
        dynparam('set', name, 'format', 'png')
        wait_for(lambda: self._get(publisher, recorder, picture()).format ==
                 'rgb8; png compressed bgr8', 'png')
        self.assertEqual('png', rospy.get_param(name + '/format'))
        client = Client(name, timeout=DEADLINE_S * stretch())
        for numbers, used in (({'jpeg_quality': 200, 'png_level': 0}, (100, 1)),
                              ({'jpeg_quality': 0, 'png_level': 10}, (1, 9))):
            client.update_configuration(numbers)
            wait_for(lambda: {each.name: each.value for each in updates.messages[-1].ints
                              if each.name in numbers} == dict(zip(numbers, used)),
                     'the nearest numbers')
            self.assertEqual(used, (rospy.get_param(name + '/jpeg_quality'),
                                    rospy.get_param(name + '/png_level')))
        client.update_configuration({'format': 'gif'})
        publisher.publish(picture(), 'rgb8', header())
        self._wait_log(Log.WARN, name, 'as gif: the format has to be one of jpeg, png')
        client.update_configuration({'format': 'jpeg'})
        self._get(publisher, recorder, picture())
        self.assertEqual(50, client.update_configuration({'jpeg_quality': 50})['jpeg_quality'])
        client.close()

    def test_color_extract_gets_the_same_results_from_png_as_from_raw(self):
        rospy.set_param('/usb_cam/image_raw/compressed/format', 'png')
        raw = rospy.Publisher('/usb_cam/image_raw', Image, queue_size=10)
        compressed = self._publisher('/usb_cam/image_raw')
        areas = {node: AreaLines('/' + node) for node in NODES}
        twists = {'color_extract': Recorder('/cmd_vel', Twist, from_node('/color_extract')),
                  'from_compressed': Recorder('/from_compressed/cmd_vel', Twist)}
        images = {(node, color): Recorder(prefix + color + '_image', Image)
                  for node, prefix in zip(NODES, ('/', '/from_compressed/'))
                  for color in ('blue', 'red')}
        wait_for(lambda: raw.get_num_connections() == 1 and compressed.is_wanted(),
                 'both nodes to subscribe')

        def send(image):
            before = {node: len(areas[node].messages) for node in NODES}
            sent = header()
            raw.publish(image_msgs.to_msg(image, 'rgb8', sent))
            compressed.publish(image, 'rgb8', sent)
            wait_for(lambda: all(len(areas[node].messages) > before[node] for node in NODES),
                     'areas of both nodes')
            return sent.stamp

        def connected():
            send(picture(2000, 2000))
            return all(each.messages for each in [*twists.values(), *images.values()])
        wait_for(connected, 'the outputs of both nodes')
        cases = [(0, 0), (1000, 1000), (0, 1500), (0, 1001), (2345, 3456)]
        for number, (blue, red) in enumerate(cases):
            stamp = send(picture(blue, red, number))
            self.assertEqual(*(areas[node].messages[-1].msg for node in NODES))
            for color in ('blue', 'red'):
                pair = [images[node, color] for node in NODES]
                wait_for(lambda: all(each.messages[-1].header.stamp == stamp for each in pair),
                         color + '_image')
                self.assertEqual(*(each.messages[-1].data for each in pair))
        for node in NODES:
            # the first Twist is of the last frame before the cases; the first two cases give none
            wait_for(lambda: [twist.linear.x for twist in twists[node].messages[-5:]] ==
                     [-10.0, -10.0, -10.0, 10.0, -10.0], 'the Twists of ' + node)

        self._check_undecodable_is_skipped(areas['from_compressed'])
        send(picture(5000, 0))      # the node continues
        self.assertEqual(*(areas[node].messages[-1].msg for node in NODES))

    def _check_undecodable_is_skipped(self, areas):
        before = len(areas.messages)
        other = rospy.Publisher('/usb_cam/image_raw/compressed', CompressedImage, queue_size=10)
        wait_for(lambda: other.get_num_connections() == 1, 'from_compressed to subscribe')
        other.publish(CompressedImage(format='rgb8; png compressed bgr8', data=b'no image'))
        self._wait_log(Log.WARN, 'frame skipped: cannot decode', '8 bytes')
        self.assertEqual(before, len(areas.messages))


if __name__ == '__main__':
    main(CompressedTest)
