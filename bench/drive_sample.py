"""Drive the robots of a running simulator in circles; print what they cost as JSON.

The simulator has other subscribers in turn. A loop of PyBullet alone may take turns with it, while
the simulator is stopped: so a slow moment of the machine affects both.

Argument: JSON with robots (their namespaces), pids (of the nodes, that of the simulator first),
seconds, turns, subscribers (lists of topics), and bare: whether to measure that loop too.
"""
import json
import os
import signal
import sys
import time
from typing import Iterable, List

import psutil
import raw_topics
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros_processes import Sampler, cpu_s, descendants
from rosgraph_msgs.msg import Clock

STEPS_A_SECOND = 1000       # of simulated time


def bare_steps_per_s(loop: Sampler, pid: int, seconds: float) -> float:
    """Let bare_loop.py simulate for so long, while a process stands still."""
    os.kill(pid, signal.SIGSTOP)
    try:
        return loop.sample(seconds)
    finally:
        os.kill(pid, signal.SIGCONT)


def simulated_s() -> float:
    """Return the time in the next message on /clock."""
    return rospy.wait_for_message('/clock', Clock).clock.to_sec()


def memory_mb(pids: Iterable[int]) -> float:
    """Return the memory of processes; what several share is counted once."""
    return sum(psutil.Process(pid).memory_full_info().pss for pid in pids) / (1 << 20)


def drive(robots: List[str]) -> None:
    """Command the robots; return once the last one turns."""
    command = Twist()
    command.linear.x, command.angular.z = 0.02, 0.5
    publishers = [rospy.Publisher(robot + '/cmd_vel', Twist, latch=True, queue_size=1)
                  for robot in robots]
    for publisher in publishers:
        publisher.publish(command)
    while rospy.wait_for_message(robots[-1] + '/odom', Odometry).twist.twist.angular.z < 0.45:
        time.sleep(0.1)
    for publisher in publishers:
        publisher.unregister()


def sample(pids: List[int], seconds: float, robots: int) -> dict:
    """Return speed, CPU and memory of the nodes and all that they have started."""
    every = descendants(*pids)
    simulated, wall, before = simulated_s(), time.perf_counter(), sum(map(cpu_s, every))
    time.sleep(seconds)
    simulated = simulated_s() - simulated
    processor, wall = sum(map(cpu_s, every)) - before, time.perf_counter() - wall
    steps = simulated * STEPS_A_SECOND
    return {'factor': simulated / wall, 'steps_per_s': steps / wall, 'cpu_share': processor / wall,
            'step_us': 1e6 * processor / steps, 'robot_step_us': 1e6 * processor / steps / robots,
            'memory_mb': memory_mb(every)}


def main() -> None:
    """Measure."""
    given = json.loads(sys.argv[1])
    robots, pids, seconds = given['robots'], given['pids'], given['seconds']
    rospy.init_node('drive_sample', disable_rostime=True)
    drive(robots)
    bare, found = Sampler('bare_loop.py') if given['bare'] else None, []
    for _ in range(given['turns']):
        turn = []
        for topics in given['subscribers']:
            alone = bare and bare_steps_per_s(bare, pids[0], seconds)
            with raw_topics.Readers(topics, os.environ['ROS_MASTER_URI']):
                one = sample(pids, seconds, len(robots))
            turn.append({**one, **({'of_bare': one['steps_per_s'] / alone, 'bare': alone}
                                   if alone else {})})
        found.append(turn)
    sys.stdout.write(json.dumps(found) + '\n')


if __name__ == '__main__':
    main()
