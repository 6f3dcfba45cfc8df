#!/usr/bin/env python3
"""Turn until the camera sees blue, drive there and stop: one command for each image."""
import numpy
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image


def answer(msg):
    """Publish the command for an image (rgb8)."""
    pixels = numpy.frombuffer(msg.data, 'u1').reshape(msg.height, msg.width, 3).astype('i2')
    red, green, blue = pixels[..., 0], pixels[..., 1], pixels[..., 2]
    is_blue = blue > numpy.maximum(red, green) + 60
    columns = numpy.flatnonzero(is_blue.any(axis=0)) / msg.width
    command = Twist()
    if not columns.size:
        command.angular.z = 0.5
    elif columns[-1] - columns[0] < 0.25:
        command.linear.x = 0.2
        command.angular.z = 0.5 - columns.mean()
    velocity.publish(command)


if __name__ == '__main__':
    rospy.init_node('my_robot_vision')
    velocity = rospy.Publisher('cmd_vel', Twist, queue_size=10)
    rospy.Subscriber('usb_cam/image_raw', Image, answer, queue_size=1, buff_size=1 << 24)
    rospy.spin()
