"""republish.py: raw images to compressed ones and back, only while somebody subscribes."""
import time

import cv2
import numpy as np
import pytest
import rospy
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog_helpers import wire
from img_recog_helpers.waiting import wait_for

HEADER = Header(stamp=rospy.Time(12, 345), frame_id='lens')
PIXELS = cv2.resize(np.random.RandomState(0).randint(0, 256, (4, 6, 3), np.uint8), (60, 40))


@pytest.fixture
def relay(shared_ros):
    """A function that starts a relay; `relay.publisher` and `relay.subscription` are its ends."""
    def start(*words, name='relay', parameters=()):
        for key, value in dict(parameters).items():
            shared_ros.set_parameters(key, value)
        return shared_ros.start_node('republish.py', *words, '__name:=' + name)

    def publisher(topic, kind):
        made = wire.RawPublisher(shared_ros.master_uri, topic, kind)
        shared_ros.stack.callback(made.close)
        return made

    def subscription(topic, kind, node='/relay'):
        def connect():
            try:
                return wire.Subscription(shared_ros.master_uri, node, topic, kind)
            except wire.ERRORS:
                return None
        made = wait_for(connect, topic)
        shared_ros.stack.callback(made.close)
        return made
    start.publisher, start.subscription = publisher, subscription
    return start


def passed(publisher, msg, subscription):
    """Return the first message that comes out when `msg` is published again and again."""
    def attempt():
        publisher.publish(msg)
        time.sleep(0.05)
        return subscription.read()
    return wait_for(attempt, subscription.topic)[0]


@pytest.mark.parametrize('kind, encoding, compressed, largest_error', (
    ('png', 'rgb8', 'rgb8; png compressed bgr8', 0),
    ('jpeg', 'bgr8', 'bgr8; jpeg compressed bgr8', 12),
    ('png', 'mono8', 'mono8; png compressed ', 0)))
def test_there_and_back(relay, kind, encoding, compressed, largest_error):
    relay('raw', 'in:=/camera', 'compressed', 'out:=/small', name='there', parameters={
        '/small/compressed': {'format': kind, 'jpeg_quality': 100, 'png_level': 1}})
    relay('compressed', 'in:=/small', 'raw', 'out:=/back', name='back')
    pixels = PIXELS if encoding != 'mono8' else PIXELS[..., 0]
    camera = relay.publisher('/camera', Image)
    between = relay.subscription('/small/compressed', CompressedImage, '/there')
    end = relay.subscription('/back', Image, '/back')
    msg = image_msgs.to_msg(np.ascontiguousarray(pixels), encoding, HEADER)
    back = passed(camera, msg, end)
    assert (back.encoding, back.header.stamp, back.header.frame_id) == (
        encoding, HEADER.stamp, 'lens')
    error = np.abs(image_msgs.from_msg(back, encoding).astype(int) - pixels).max()
    assert error <= largest_error
    small = wait_for(between.read, 'compressed images')[0]
    assert (small.format, small.header.stamp) == (compressed, HEADER.stamp)


def test_it_subscribes_only_while_somebody_subscribes(relay):
    relay('raw', 'in:=/camera', 'out:=/small')
    camera = relay.publisher('/camera', Image)
    msg = image_msgs.to_msg(PIXELS, 'bgr8', HEADER)
    for _ in range(2):
        end = relay.subscription('/small/compressed', CompressedImage)
        passed(camera, msg, end)
        end.close()
        wait_for(lambda: camera.publish(msg) == 0, 'the relay to unsubscribe')


def test_what_cannot_be_converted_is_one_line(relay):
    process = relay('raw', 'in:=/camera', 'out:=/small', '_max_image_pixels:=3000')
    camera = relay.publisher('/camera', Image)
    end = relay.subscription('/small/compressed', CompressedImage)
    good = image_msgs.to_msg(PIXELS, 'bgr8', HEADER)
    passed(camera, good, end)
    camera.publish(Image(HEADER, 2, 2, '32FC1', 0, 8, bytes(16)))
    process.wait_output(r'\[WARN\].*skipped: cannot convert an image of 2x2 to bgr8: encoding '
                        '32FC1 does not say which colors')
    camera.publish(image_msgs.to_msg(np.zeros((60, 60, 3), np.uint8), 'bgr8', HEADER))
    process.wait_output(r'image skipped: 60x60 are 3600 pixels, more than max_image_pixels = 3000')
    passed(camera, good, end)
    assert 'Traceback' not in process.output


def test_compressed_data_that_are_none_are_one_line(relay):
    process = relay('compressed', 'in:=/small', 'out:=/back')
    small = relay.publisher('/small/compressed', CompressedImage)
    end = relay.subscription('/back', Image)
    good = compressed_image_msgs.to_msg(PIXELS, 'bgr8', HEADER)
    passed(small, good, end)
    small.publish(CompressedImage(HEADER, 'bgr8; jpeg compressed bgr8', b'\xff\xd8 no image'))
    process.wait_output(r"\[WARN\].*skipped: cannot decode a compressed image of format 'bgr8")
    passed(small, good, end)
    assert 'Traceback' not in process.output


@pytest.mark.parametrize('words, got', (((), 'nothing'), (('raw', 'theora'), 'raw theora')))
def test_other_transports_are_refused(relay, words, got):
    assert 'got {}, wants the transports: raw compressed, or compressed raw; '.format(
        got) in relay(*words).fatal_line()
