"""Print how long simulated time takes with a node that answers, as JSON.

Argument: SECONDS of simulated time, from the first command on.
"""
import json
import sys
import time

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros_processes import wait_for


def main() -> None:
    """Measure."""
    end_s = float(sys.argv[1])
    rospy.init_node('lockstep_sample', disable_rostime=True)
    commands, times = [], []

    def note(msg: Odometry) -> None:
        if commands and (not times or times[-1][0] < times[0][0] + end_s):
            times.append((msg.header.stamp.to_sec(), time.monotonic()))
    rospy.Subscriber('cmd_vel', Twist, commands.append, tcp_nodelay=True)
    rospy.Subscriber('odom', Odometry, note, tcp_nodelay=True)
    wait_for(lambda: times and times[-1][0] >= times[0][0] + end_s, 'simulated time', 0.001)
    sys.stdout.write(json.dumps({
        'wall_s': times[-1][1] - times[0][1], 'commands': len(commands)}) + '\n')


if __name__ == '__main__':
    main()
