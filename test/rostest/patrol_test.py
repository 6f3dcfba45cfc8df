#!/usr/bin/env python3
"""A robot that is driven only by its scan moves through turtlebot3_world without collisions."""
import math
import unittest

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from img_recog_helpers import turtlebot3_world
from img_recog_helpers.driven import place, yaw
from img_recog_helpers.recording import Recorder, main, wait_for

SIMULATED_S = 180.0
# a circle around the burger seen from above: x of its center from base_footprint, and radius, m
CENTER_X, RADIUS = -0.032, 0.112


class Driver:
    """Drives ahead, steers away from near obstacles, and turns in place before an obstacle."""

    def __init__(self):
        self._turn = 0.0
        self._commands = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
        rospy.Subscriber('/scan', LaserScan, self._drive, queue_size=1, tcp_nodelay=True)

    def _drive(self, scan):
        angles = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment
        angles = (angles + math.pi) % (2 * math.pi) - math.pi
        ranges = np.minimum(scan.ranges, scan.range_max)
        ahead = ranges[np.abs(angles) < math.radians(45)].min()
        left, right = (ranges[np.abs(angles - side * math.radians(60)) < math.radians(50)].min()
                       for side in (1, -1))
        command = Twist()
        if ahead < 0.4:
            self._turn = self._turn or math.copysign(1.0, left - right)
            command.angular.z = self._turn
        else:
            self._turn = 0.0
            command.linear.x = 0.2
            command.angular.z = min(left, 0.6) - min(right, 0.6)
        self._commands.publish(command)


def center_of(msg):
    (x, y), angle = place(msg), yaw(msg)
    return np.array((x + CENTER_X * math.cos(angle), y + CENTER_X * math.sin(angle)))


class PatrolTest(unittest.TestCase):
    """Checks the true pose while the driver runs."""

    def test_three_minutes_without_a_collision(self):
        odometry = Recorder('/odom', Odometry)
        odometry.wait()
        start = odometry.messages[0].header.stamp.to_sec()
        Driver()
        wait_for(lambda: odometry.messages[-1].header.stamp.to_sec() > start + SIMULATED_S,
                 'three simulated minutes', deadline_s=280.0)
        path = np.array([center_of(msg) for msg in odometry.messages])
        nearest = min(turtlebot3_world.clearance(point) for point in path)
        self.assertGreater(nearest, RADIUS)
        length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        self.assertGreater(length, 10.0)
        # it does not only drive in a small circle
        self.assertGreater(np.ptp(path, axis=0).min(), 1.0)
        rospy.loginfo('drove %.1f m, minimum distance %.3f m', length, nearest - RADIUS)


if __name__ == '__main__':
    main(PatrolTest)
