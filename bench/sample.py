"""Drive the robot of a running simulator in a circle; print speed and CPU share as JSON."""
import json
import sys
import time

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros_processes import cpu_s
from rosgraph_msgs.msg import Clock


def simulated_s() -> float:
    """Return the time in the next message on /clock."""
    return rospy.wait_for_message('/clock', Clock).clock.to_sec()


def main() -> int:
    """Measure the process PID for SECONDS."""
    seconds, pid = float(sys.argv[1]), int(sys.argv[2])
    rospy.init_node('sample', disable_rostime=True)
    commands = rospy.Publisher('/cmd_vel', Twist, latch=True, queue_size=1)
    command = Twist()
    command.linear.x, command.angular.z = 0.1, 0.5
    commands.publish(command)
    while rospy.wait_for_message('/odom', Odometry).twist.twist.linear.x < 0.09:
        time.sleep(0.1)
    commands.unregister()
    simulated, processor, wall = simulated_s(), cpu_s(pid), time.perf_counter()
    time.sleep(seconds)
    simulated = simulated_s() - simulated
    processor, wall = cpu_s(pid) - processor, time.perf_counter() - wall
    sys.stdout.write(json.dumps({'real_time_factor': simulated / wall,
                                 'cpu_share': processor / wall}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
