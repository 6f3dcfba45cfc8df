"""Images of a running camera: the limit of the rate, and the compressed topic."""
import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage

from camera_node import Topic, intervals, range_text
from img_recog_testing.waiting import wait_for


def check_rate(report, vivid, node, images):
    """Check that frames of a camera that gives more than `framerate` are dropped evenly."""
    with report.check('framerate 20 of a camera that gives 60', node) as measured:
        vivid.set_rate(60)
        images.wait_more(10)        # until the throttle has measured the rate of the camera
        first = len(images.stamps)
        images.wait_more(80)
        intervals_s = intervals(images.stamps[first:])
        rate_hz = len(intervals_s) / sum(intervals_s)
        even = sum(abs(step - 0.05) < 0.012 for step in intervals_s) / len(intervals_s)
        measured.append('{:.2f} Hz, {:.0%} of the steps 50 ms, {}'.format(
            rate_hz, even, range_text(intervals_s)))
        assert abs(rate_hz - 20) < 1.5 and even > 0.5 and min(intervals_s) > 0, measured


def check_compressed(report, node, images):
    """Check that image_raw/compressed has JPEG images with the stamps of the raw ones."""
    with report.check('image_raw/compressed', node) as measured:
        topic = Topic('/usb_cam/image_raw/compressed', CompressedImage)
        msg = topic.wait_more(3)
        measured.append(msg.format)
        assert 'jpeg' in msg.format and msg.data[:2] == b'\xff\xd8', msg.data[:2]
        image = cv2.imdecode(np.frombuffer(msg.data, np.uint8), cv2.IMREAD_COLOR)
        assert image.shape == (180, 320, 3), image.shape
        wait_for(lambda: set(topic.stamps) & set(images.stamps), 'the stamp of a raw image')
        topic.close()
