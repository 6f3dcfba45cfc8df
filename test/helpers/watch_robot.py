"""Prints a JSON line ten times a second: what the robot does, and how old its images are.

wall_s: of the clock; speed: of the odometry, m/s; frames: number of images that were recognized;
age_s: simulated time since the newest of them was taken, at the time it was recognized.
"""
import json
import sys
import time

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud

_PERIOD_S = 0.1


class Watch:
    """Keeps what arrived last."""

    def __init__(self):
        self.speed, self.frames, self.age_s = 0.0, 0, None
        rospy.Subscriber('odom', Odometry, self._odometry, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber('color_detection', PointCloud, self._detection, queue_size=1,
                         tcp_nodelay=True)

    def _odometry(self, msg):
        self.speed = msg.twist.twist.linear.x

    def _detection(self, msg):
        self.frames += 1
        self.age_s = (rospy.get_rostime() - msg.header.stamp).to_sec()


def main():
    """Print until the node is shut down."""
    rospy.init_node('watch_robot')
    watch = Watch()
    while not rospy.is_shutdown():
        print(json.dumps({'wall_s': time.monotonic(), **vars(watch)}), flush=True)
        time.sleep(_PERIOD_S)


if __name__ == '__main__':
    sys.exit(main())
