"""What a robot that drives by its camera sees and does, recorded for the rostests."""
import math

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, PointCloud

from img_recog_helpers.recording import Recorder, call, from_node
from img_recog_helpers.waiting import wait_for

START = -2.0, -0.5


class Robot:
    """Records the odometry, the scans, the areas of colors and the commands for them."""

    def __init__(self):
        self.odometry = Recorder('/odom', Odometry)
        self.scans = Recorder('/scan', LaserScan)
        self.detections = Recorder('/color_detection', PointCloud)
        self.commands = Recorder('/cmd_vel', Twist, from_node('/color_extract'))
        for recorder in (self.odometry, self.scans, self.detections):
            recorder.wait()
        self.commands.wait_connected('/color_extract')

    def begin_again(self):
        """Move the robot to its start, and forget what was before."""
        since = reset_world({self.odometry: START})
        for recorder in (self.odometry, self.scans, self.detections):
            recorder.forget(since)
        self.commands.messages = []

    def areas(self, color):
        """Return the stamp and the area in pixels of a color, of each image."""
        return [(msg.header.stamp.to_sec(), channel.values[number])
                for msg in list(self.detections.messages)
                for number, channel in enumerate(msg.channels) if channel.name == color]

    def rests(self, seconds):
        """Return whether the robot has stood for so long, in simulated time."""
        messages = list(self.odometry.messages)
        last = messages[-1].header.stamp
        if last - messages[0].header.stamp < rospy.Duration(seconds):
            return False
        return all(math.dist(place(msg), place(messages[-1])) < 0.002
                   and abs(yaw(msg) - yaw(messages[-1])) < 0.005 for msg in reversed(messages)
                   if last - msg.header.stamp < rospy.Duration(seconds))


def reset_world(starts):
    """Move all robots to their starts, and return when the last of them was there.

    starts: x and y by the Recorder of a robot's odometry.
    """
    call('/gazebo/reset_world')
    # what was sent before may still be on its way, from robots that have hardly left their starts
    since = rospy.Time.now() + rospy.Duration(0.1)

    def stamps():       # they may drive away at once
        found = [[msg.header.stamp for msg in list(recorder.messages)
                  if msg.header.stamp > since and math.dist(place(msg), start) < 0.05]
                 for recorder, start in starts.items()]
        return [each[-1] for each in found] if all(found) else None
    return max(wait_for(stamps, 'the robots at their starts'))


def place(msg):
    """Return x and y of an odometry."""
    return msg.pose.pose.position.x, msg.pose.pose.position.y


def yaw(msg):
    """Return the heading of an odometry."""
    return 2 * math.atan2(msg.pose.pose.orientation.z, msg.pose.pose.orientation.w)
