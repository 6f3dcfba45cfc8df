"""A node as a user writes it: turns until it sees blue, then drives there; a command an image."""
import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image


def main() -> None:
    """Run the node until it is shut down."""
    rospy.init_node('follower')
    bridge, velocity = CvBridge(), rospy.Publisher('cmd_vel', Twist, queue_size=1)

    def drive(msg: Image) -> None:
        hsv = cv2.cvtColor(bridge.imgmsg_to_cv2(msg, 'bgr8'), cv2.COLOR_BGR2HSV)
        columns = np.flatnonzero(cv2.inRange(hsv, (100, 100, 30), (130, 255, 255)).any(axis=0))
        command = Twist()
        command.linear.x = 0.15 if len(columns) else 0.0
        command.angular.z = 0.5 - columns.mean() / msg.width if len(columns) else 0.4
        velocity.publish(command)
    rospy.Subscriber('usb_cam/image_raw', Image, drive, queue_size=1, buff_size=1 << 24)
    rospy.spin()


if __name__ == '__main__':
    main()
