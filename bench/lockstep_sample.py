"""Print how long simulated time takes with a node that answers, and its path, as JSON.

Argument: SECONDS of simulated time, from the first command on.
"""
import hashlib
import json
import sys
import time

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros_processes import wait_for


def main() -> int:
    """Measure."""
    end_s = float(sys.argv[1])
    rospy.init_node('lockstep_sample', disable_rostime=True)
    commands, path = [], []

    def note(msg: Odometry) -> None:
        if commands and (not path or path[-1][0] < path[0][0] + end_s):
            path.append((msg.header.stamp.to_sec(), msg.pose.pose.position.x,
                         msg.pose.pose.position.y, time.monotonic()))
    rospy.Subscriber('cmd_vel', Twist, commands.append, tcp_nodelay=True)
    rospy.Subscriber('odom', Odometry, note, tcp_nodelay=True)
    wait_for(lambda: path and path[-1][0] >= path[0][0] + end_s, 'simulated time', 0.001)
    sys.stdout.write(json.dumps({
        'wall_s': path[-1][3] - path[0][3], 'commands': len(commands),
        'path': hashlib.sha256(repr([row[:3] for row in path]).encode()).hexdigest()}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
