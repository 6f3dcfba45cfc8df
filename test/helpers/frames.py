"""Frames for rostests: pictures of known areas, and their messages."""
import numpy as np
import rospy
from sensor_msgs.msg import Image

BLUE, RED, GREY = (200, 60, 20), (60, 20, 220), (128, 128, 128)     # BGR


def picture(blue_px=0, red_px=0, size=(320, 240), seed=None):
    """Return a bgr8 picture with this number of pixels of each color, on grey or noise of grey."""
    width, height = size
    image = np.full((height * width, 3), GREY, np.uint8)
    if seed is not None:
        image[:] = np.random.RandomState(seed).randint(110, 150, image.shape)
    image[:blue_px], image[len(image) - red_px:] = BLUE, RED
    return image.reshape(height, width, 3)


def message(image, encoding='bgr8', padding=0, stamp=None):
    """Return an Image message in which `padding` bytes of 255 follow each row, by default of now.

    It is plain, so that it is independent of the package.
    """
    rows = image.reshape(image.shape[0], -1)
    data = np.full((len(rows), rows.shape[1] + padding), 255, np.uint8)
    data[:, :rows.shape[1]] = rows
    msg = Image(height=image.shape[0], width=image.shape[1], encoding=encoding,
                step=data.shape[1], data=data.tobytes())
    msg.header.stamp, msg.header.frame_id = stamp or rospy.Time.now(), 'test_camera'
    return msg
