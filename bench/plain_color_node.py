"""A simple recognition node like the article's, for comparison.

For each frame, in rospy's receiving thread, it does the same as the article's node: for each
color, convert to HSV, cv2.inRange, cv2.bitwise_and and count; then publish both images, log, and
publish the commands.
"""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image

RANGES = {'blue': (np.array([50, 100, 100]), np.array([150, 255, 255])),
          'red': (np.array([150, 100, 150]), np.array([180, 255, 255]))}
SPEEDS, LIMIT_PX = {'blue': 10, 'red': -10}, 1000


def main() -> None:
    """Run until shut down."""
    rospy.init_node('color_extract')
    bridge, velocity = CvBridge(), rospy.Publisher('cmd_vel', Twist, queue_size=10)
    images = {color: rospy.Publisher(color + '_image', Image, queue_size=1) for color in RANGES}

    def handle(msg: Image) -> None:
        image = bridge.imgmsg_to_cv2(msg, 'bgr8')
        areas_px = {}
        for color, (lower, upper) in RANGES.items():
            mask = cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), lower, upper)
            areas_px[color] = cv2.countNonZero(mask)
            images[color].publish(bridge.cv2_to_imgmsg(
                cv2.bitwise_and(image, image, mask=mask), 'bgr8'))
        rospy.loginfo('blue=%d, red=%d', areas_px['blue'], areas_px['red'])
        for color, area_px in areas_px.items():
            if area_px > LIMIT_PX:
                velocity.publish(Twist(linear=Vector3(x=SPEEDS[color])))
    rospy.Subscriber('usb_cam/image_raw', Image, handle)
    rospy.spin()


if __name__ == '__main__':
    main()
