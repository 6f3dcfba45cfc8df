"""Drive the robot of a running simulator in a circle; print speed and CPU shares as JSON.

The simulator has other subscribers in turn. In free run, a loop of PyBullet alone takes turns with
it, while the simulator is stopped: so a slow moment of the machine affects all of them.
"""
import json
import os
import signal
import subprocess
import sys
import time

import raw_topics
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from ros_processes import HERE, cpu_s
from rosgraph_msgs.msg import Clock


class BareLoop:
    """A running bare_loop.py."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, os.path.join(HERE, 'bare_loop.py')], stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, universal_newlines=True, bufsize=1)

    def steps_per_s(self, seconds: float) -> float:
        """Let it simulate for so long."""
        self._process.stdin.write('{}\n'.format(seconds))
        return float(self._process.stdout.readline())


def simulated_s() -> float:
    """Return the time in the next message on /clock."""
    return rospy.wait_for_message('/clock', Clock).clock.to_sec()


def sample(pid: int, seconds: float) -> dict:
    """Return the speed and the CPU share of the simulator, a process."""
    simulated, processor, wall = simulated_s(), cpu_s(pid), time.perf_counter()
    time.sleep(seconds)
    simulated = simulated_s() - simulated
    processor, wall = cpu_s(pid) - processor, time.perf_counter() - wall
    return {'real_time_factor': simulated / wall, 'cpu_share': processor / wall}


def main() -> int:
    """Measure the process PID for SECONDS, TURNS times with each of some subscribers.

    SUBSCRIBERS: JSON, a list of lists of topics. FREE: 1 for a free run, or 0.
    """
    pid, seconds, turns = int(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3])
    subscribers, is_free = json.loads(sys.argv[4]), bool(int(sys.argv[5]))
    rospy.init_node('sample', disable_rostime=True)
    commands = rospy.Publisher('/cmd_vel', Twist, latch=True, queue_size=1)
    command = Twist()
    command.linear.x, command.angular.z = 0.1, 0.5
    commands.publish(command)
    while rospy.wait_for_message('/odom', Odometry).twist.twist.linear.x < 0.09:
        time.sleep(0.1)
    commands.unregister()
    bare_loop = BareLoop() if is_free else None
    found = []
    for _ in range(turns):
        turn = []
        for topics in subscribers:
            alone = {}
            if bare_loop:
                os.kill(pid, signal.SIGSTOP)
                try:
                    alone = {'bare_steps_per_s': bare_loop.steps_per_s(seconds)}
                finally:
                    os.kill(pid, signal.SIGCONT)
            with raw_topics.Readers(topics, os.environ['ROS_MASTER_URI']):
                turn.append({**sample(pid, seconds), **alone})
        found.append(turn)
    sys.stdout.write(json.dumps(found) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
