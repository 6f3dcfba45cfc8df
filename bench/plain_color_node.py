"""A simple recognition node like the article's, for comparison.

For each frame, in rospy's receiving thread, it does the same as the article's node: for each
color, convert to HSV, cv2.inRange, cv2.bitwise_and and count; then publish both images, log, and
publish the commands.
"""
import sys

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image

BLUE = np.array([50, 100, 100]), np.array([150, 255, 255])
RED = np.array([150, 100, 150]), np.array([180, 255, 255])
LIMIT_PX = 1000


class PlainNode:
    """Subscribes to usb_cam/image_raw; publishes blue_image, red_image and cmd_vel."""

    def __init__(self):
        self.bridge = CvBridge()
        self.velocity = rospy.Publisher('cmd_vel', Twist, queue_size=10)
        self.blue = rospy.Publisher('blue_image', Image, queue_size=1)
        self.red = rospy.Publisher('red_image', Image, queue_size=1)
        rospy.Subscriber('usb_cam/image_raw', Image, self.handle)

    def handle(self, msg):
        """Process a frame."""
        image = self.bridge.imgmsg_to_cv2(msg, 'bgr8')
        blue_px, blue_image = self.extract(image, *BLUE)
        red_px, red_image = self.extract(image, *RED)
        self.blue.publish(self.bridge.cv2_to_imgmsg(blue_image, 'bgr8'))
        self.red.publish(self.bridge.cv2_to_imgmsg(red_image, 'bgr8'))
        rospy.loginfo('blue=%d, red=%d', blue_px, red_px)
        if blue_px > LIMIT_PX:
            self.command(10)
        if red_px > LIMIT_PX:
            self.command(-10)

    @staticmethod
    def extract(image, lower, upper):
        """Return the area of a color in pixels, and the image with all other pixels black."""
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        mask = cv2.inRange(hsv, lower, upper)
        return cv2.countNonZero(mask), cv2.bitwise_and(image, image, mask=mask)

    def command(self, linear_x):
        """Publish a command with this linear.x."""
        twist = Twist()
        twist.linear.x = linear_x
        self.velocity.publish(twist)


def main() -> int:
    """Run until shut down."""
    rospy.init_node('color_extract')
    PlainNode()
    rospy.spin()
    return 0


if __name__ == '__main__':
    sys.exit(main())
