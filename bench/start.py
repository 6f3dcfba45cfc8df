"""Time from ./run demo, with nothing to install, until the robot moves."""
import os
import socket
import subprocess
import time
from typing import Dict

import raw_topics
from nav_msgs.msg import Odometry
from pairs import Benchmark, Column, each
from ros_processes import PACKAGE, reserve, wait_for

POLL_PERIOD_S = 0.02
MOVING_M_S = 0.01
END_TIMEOUT_S = 20.0
# what ./run bench has set, but not the shell of a user
SET_BY_RUN = ('ROS_', 'CATKIN_', 'CMAKE_', 'PKG_CONFIG_', 'PYTHONPATH', 'DISPLAY')


def start() -> Dict[str, float]:
    """Start the demo, and return how long it took until each of its stages, s."""
    with reserve() as reserved:
        return _start(reserved.getsockname()[1])


def _start(port: int) -> Dict[str, float]:
    env = {name: value for name, value in os.environ.items() if not name.startswith(SET_BY_RUN)}
    env['ROS_MASTER_URI'] = uri = 'http://localhost:{}'.format(port)
    begin_s = time.perf_counter()
    demo = subprocess.Popen([os.path.join(PACKAGE, 'run'), 'demo'], env=env,
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


def benchmark() -> Benchmark:
    """Return how long starts take."""
    return Benchmark('from ./run demo until', {'': each(**{'': start})}, (
        Column('the master answers', 'master', '{:.2f} s'),
        Column('the simulator publishes', 'odometry', '{:.2f} s'),
        Column('the robot moves', 'motion', '{:.2f} s')))
