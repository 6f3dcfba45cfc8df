"""Time from ./run demo, with nothing to install, until the robot moves."""
import os
import socket
import subprocess
import time
from statistics import median
from typing import Callable, Dict

import raw_topics
from nav_msgs.msg import Odometry
from ros_processes import HERE, free_port, wait_for

RUNS = 3
POLL_PERIOD_S = 0.02
MOVING_M_S = 0.01
END_TIMEOUT_S = 20.0
# what ./run bench has set, but not the shell of a user
SET_BY_RUN = ('ROS_', 'CATKIN_', 'CMAKE_', 'PKG_CONFIG_', 'PYTHONPATH', 'DISPLAY')
STAGES = {'master': 'the master answers', 'odometry': 'the simulator publishes',
          'motion': 'the robot moves'}


def start() -> Dict[str, float]:
    """Start the demo, and return how long each of STAGES took, s."""
    port = free_port()
    env = {name: value for name, value in os.environ.items() if not name.startswith(SET_BY_RUN)}
    env['ROS_MASTER_URI'] = uri = 'http://localhost:{}'.format(port)
    begin_s = time.perf_counter()
    demo = subprocess.Popen([os.path.join(os.path.dirname(HERE), 'run'), 'demo'], env=env,
                            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, start_new_session=True)
    times = {}
    try:
        wait_for(lambda: _answers(port), 'the master', POLL_PERIOD_S)
        times['master'] = time.perf_counter() - begin_s
        with raw_topics.connect('/odom', uri, POLL_PERIOD_S) as sock:
            times['odometry'] = time.perf_counter() - begin_s
            for data in raw_topics.messages(sock):
                if abs(Odometry().deserialize(bytes(data)).twist.twist.linear.x) > MOVING_M_S:
                    times['motion'] = time.perf_counter() - begin_s
                    return times
    finally:
        demo.terminate()
        demo.wait(END_TIMEOUT_S)
    return times


def _answers(port: int) -> bool:
    try:
        socket.create_connection(('localhost', port)).close()
    except OSError:
        return False
    return True


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return RUNS


def measure(done: Callable[[], None]) -> dict:
    """Return the medians of several starts, s.

    done: called after each measurement.
    """
    samples = []
    for _ in range(RUNS):
        samples.append(start())
        done()
    return {stage: median(sample[stage] for sample in samples) for stage in STAGES}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:34} {:>8}'.format('from ./run demo until', 's')]
    lines += ['{:34} {:8.2f}'.format(words, results[stage]) for stage, words in STAGES.items()]
    return '\n'.join(lines)
