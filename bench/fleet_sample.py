"""Drive the robots of a running simulator in small circles; print what they cost as JSON.

Arguments: seconds, process ids of the nodes as JSON, names of the robots.
"""
import json
import sys
import time
from typing import Iterable, List

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros_processes import cpu_s, descendants
from rosgraph_msgs.msg import Clock

MEGABYTE = 1 << 20


def simulated_s() -> float:
    """Return the time in the next message on /clock."""
    return rospy.wait_for_message('/clock', Clock).clock.to_sec()


def memory_mb(pids: Iterable[int]) -> float:
    """Return the memory of processes; what several share is counted once."""
    total_kb = 0
    for pid in pids:
        with open('/proc/{}/smaps_rollup'.format(pid)) as file:
            total_kb += next(int(line.split()[1]) for line in file if line.startswith('Pss:'))
    return total_kb * 1024 / MEGABYTE


def drive(robots: List[str]) -> List[rospy.Publisher]:
    """Command the robots; return once the last one moves."""
    command = Twist()
    command.linear.x, command.angular.z = 0.02, 0.5
    publishers = []
    for robot in robots:
        publishers.append(rospy.Publisher('/{}/cmd_vel'.format(robot), Twist, latch=True,
                                          queue_size=1))
        publishers[-1].publish(command)
    while rospy.wait_for_message('/{}/odom'.format(robots[-1]), Odometry).twist.twist.angular.z < (
            0.45):
        time.sleep(0.1)
    return publishers


def main() -> int:
    """Measure for a number of seconds."""
    seconds, pids, robots = float(sys.argv[1]), json.loads(sys.argv[2]), sys.argv[3:]
    rospy.init_node('fleet_sample', disable_rostime=True)
    for publisher in drive(robots):
        publisher.unregister()
    every = descendants(*pids)
    simulated, wall = simulated_s(), time.perf_counter()
    before = [cpu_s(pid) for pid in every]
    time.sleep(seconds)
    simulated = simulated_s() - simulated
    processor = sum(cpu_s(pid) for pid in every) - sum(before)
    wall = time.perf_counter() - wall
    sys.stdout.write(json.dumps({
        'real_time_factor': simulated / wall, 'cpu_share': processor / wall,
        'memory_mb': memory_mb(every)}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
