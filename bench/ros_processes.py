"""Start nodes with a separate master, and measure their CPU time."""
import itertools
import json
import os
import socket
import subprocess
import sys
import threading
import time
from typing import Any, Callable, Dict, List, Optional

import psutil
import rosgraph

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.dirname(HERE)
_START_TIMEOUT_S = 60.0
_POLL = threading.Event()


class Master:
    """A context manager: a master on a free port, and the nodes that are started with it.

    env: of what uses this master; server: its interface; pid: of roscore.
    """

    def __init__(self):
        self._reserved = reserve()
        port = self._reserved.getsockname()[1]
        uri = 'http://127.0.0.1:{}'.format(port)
        self.env = dict(os.environ, ROS_MASTER_URI=uri, ROS_HOSTNAME='localhost')
        self.server = rosgraph.Master('/bench', master_uri=uri)
        self._processes = []
        self.pid = self.start('roscore', '-p', str(port)).pid

    def __enter__(self) -> 'Master':
        # /rosout too: it would subscribe to /clock if it found use_sim_time
        wait_for(self._has_started, 'the master')
        return self

    def _has_started(self) -> bool:
        try:
            topics = self.server.getSystemState()[1]
        except (OSError, rosgraph.MasterException):
            return False
        return '/rosout' in dict(topics)

    def __exit__(self, *_):
        for process in reversed(self._processes):
            if process.poll() is None:
                process.terminate()         # SIGINT may be ignored, as in a script
                try:
                    process.wait(20)
                except subprocess.TimeoutExpired:
                    process.kill()
        self._reserved.close()

    def start(self, *command: str, env: Optional[Dict[str, str]] = None, output: bool = False
              ) -> subprocess.Popen:
        """Start a program with this master; output: whether its stdout is a pipe."""
        process = subprocess.Popen(command, env={**self.env, **(env or {})},
                                   stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE if output else subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self._processes.append(process)
        return process

    def start_script(self, name: str, *arguments: str, **options: Any) -> subprocess.Popen:
        """Start a script of the package; options: of `start`."""
        return self.start(sys.executable, os.path.join(PACKAGE, 'scripts', name), *arguments,
                          **options)

    def watch(self, *topics: str) -> None:
        """Subscribe to images in another process; return when it has."""
        self.start(sys.executable, os.path.join(HERE, 'watch_images.py'), *topics,
                   '__name:=watch' + '_'.join(topics).replace('/', '_'))
        wait_for(lambda: set(topics) <= set(dict(self.server.getSystemState()[1])), 'the viewers')

    def start_simulator(self, env: Optional[Dict[str, str]] = None, **parameters: Any) -> int:
        """Start the simulator with the burger; return its process id when it publishes."""
        with open(os.path.join(PACKAGE, 'urdf', 'turtlebot3_burger.urdf')) as file:
            self.server.setParam('/robot_description', file.read())
        self.server.setParam('/use_sim_time', True)
        self.server.setParam('/gazebo', parameters)
        process = self.start_script('pybullet_sim.py', '__name:=gazebo', env=env)
        wait_for(lambda: '/clock' in dict(self.server.getPublishedTopics('')), 'the simulator')
        return process.pid


def reserve() -> socket.socket:
    """Return a socket on a free port, which no other program gets while the socket is open.

    Only a server that sets SO_REUSEADDR for this very port, like a master, can still listen on it.
    """
    reserved = socket.socket()
    reserved.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    reserved.bind(('127.0.0.1', 0))
    return reserved


def installed(package: str) -> bool:
    """Return whether a ROS package is installed."""
    return subprocess.run(['rospack', 'find', package], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL, check=False).returncode == 0


def wait_for(condition, what: str, period_s: float = 0.1):
    """Return the first true value of `condition()`; raise RuntimeError after a timeout."""
    end = time.monotonic() + _START_TIMEOUT_S
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        _POLL.wait(period_s)
    raise RuntimeError('waited {:g} s for {}'.format(_START_TIMEOUT_S, what))


def run_script(name: str, *arguments, env: Optional[Dict[str, str]] = None):
    """Run a script of this folder; return the last line of its output, decoded from JSON.

    Arguments that are no texts are given to it as JSON.
    """
    command = [sys.executable, os.path.join(HERE, name), *(
        each if isinstance(each, str) else json.dumps(each) for each in arguments)]
    output = subprocess.run(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                            check=True).stdout
    return json.loads(output.decode().splitlines()[-1])


class Sampler:
    """A running script of this folder that calls `answer`. available: whether it is ready."""

    def __init__(self, name: str, *arguments: str):
        self._process = subprocess.Popen(
            [sys.executable, os.path.join(HERE, name), *arguments], stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, universal_newlines=True, bufsize=1)
        # PyBullet writes to the standard output too
        self.available = any(line == 'ready\n' for line in iter(self._process.stdout.readline, ''))

    def sample(self, seconds: float) -> Any:
        """Let it measure for so long; return what it has measured."""
        self._process.stdin.write('{}\n'.format(seconds))
        return json.loads(self._process.stdout.readline())

    def close(self) -> None:
        """End it."""
        self._process.communicate()


def answer(measure: Callable[[float], Any]) -> None:
    """Measure for the seconds on each line of the standard input; print the results as JSON."""
    for text in itertools.chain(['ready\n'], (
            json.dumps(measure(float(line))) + '\n' for line in sys.stdin)):
        sys.stdout.write(text)
        sys.stdout.flush()


def descendants(*pids: int) -> List[int]:
    """Return the ids of processes and of all their descendants."""
    return [*pids, *(each.pid for pid in pids
                     for each in psutil.Process(pid).children(recursive=True))]


def cpu_s(pid: int) -> float:
    """Return the CPU time of a process so far, in seconds."""
    # the CPU clock of a process, computed like in clock_getcpuclockid(3); /proc counts in ticks of
    # 10 ms, the CPU time of ten frames
    return time.clock_gettime((~pid << 3) | 2)
