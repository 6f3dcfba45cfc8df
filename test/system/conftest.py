"""Whole processes under test, each with a master of its own on a free port."""
import copy
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import xmlrpc.client

import pytest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from simulator_tools import burger  # noqa: E402
from waiting import wait_for  # noqa: E402


class Process:
    """A program whose output is collected while it runs."""

    def __init__(self, command, env, **popen):
        self.output = ''
        self._popen = subprocess.Popen(
            [str(word) for word in command], env=env, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, **{'stdin': subprocess.DEVNULL, **popen})
        self.pid = self._popen.pid
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._popen.stdout:
            self.output += line.decode(errors='replace')

    def wait_output(self, pattern):
        """Return the match of a regular expression in the output once it is there."""
        return wait_for(lambda: re.search(pattern, self.output),
                        lambda: '{!r} in:\n{}'.format(pattern, self.output))

    def wait(self):
        """Return the exit code once the program has ended by itself."""
        wait_for(lambda: self._popen.poll() is not None,
                 lambda: 'the end of:\n' + self.output)
        self._reader.join(5)
        return self._popen.returncode

    def interrupt(self):
        """Press Ctrl-C for it and return its exit code."""
        self._popen.send_signal(signal.SIGINT)
        return self.wait()

    def close(self):
        """End it, gently if it listens."""
        if self._popen.poll() is None:
            self._popen.send_signal(signal.SIGINT)
            try:
                self._popen.wait(20)
            except subprocess.TimeoutExpired:
                self._popen.kill()


class Ros:
    """Starts programs that share one master."""

    def __init__(self, tmp_path):
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self.port = probe.getsockname()[1]
        self.env = dict(os.environ, ROS_MASTER_URI='http://127.0.0.1:{}'.format(self.port),
                        ROS_HOSTNAME='127.0.0.1', ROS_HOME=str(tmp_path / 'ros'),
                        PYTHONUNBUFFERED='1')
        self.env.pop('DISPLAY', None)
        self._processes = []

    def start(self, *command, **popen):
        """Start a program and return its Process."""
        process = Process(command, popen.pop('env', self.env), **popen)
        self._processes.append(process)
        return process

    def demo(self, *arguments):
        """Start the demo, by default with the synthetic camera."""
        return self.start('roslaunch', '-p', self.port, 'img_recog', 'demo.launch',
                          'camera:=synthetic', *arguments)

    def run(self, *command):
        """Run a program to its end and return its output."""
        process = self.start(*command)
        process.wait()
        return process.output

    def wait_run(self, pattern, *command):
        """Repeat a program until a regular expression matches its output; return the match."""
        return wait_for(lambda: re.search(pattern, self.run(*command)),
                        lambda: '{!r} from {}'.format(pattern, command))

    def close(self):
        """End what was started, the last first."""
        for process in reversed(self._processes):
            process.close()


@pytest.fixture
def ros(tmp_path):
    """A master address of its own for one test."""
    ros = Ros(tmp_path)
    yield ros
    ros.close()


@pytest.fixture(scope='module')
def roscore(tmp_path_factory):
    """A running master for the tests of one module."""
    ros = Ros(tmp_path_factory.mktemp('roscore'))
    core = ros.start('roscore', '-p', ros.port)
    core.wait_output('started core service')
    yield ros
    ros.close()


@pytest.fixture
def shared_ros(roscore):
    """The master of a module; what a test starts is ended after it."""
    ros = copy.copy(roscore)
    ros._processes = []
    yield ros
    for process in ros._processes:
        if process._popen.poll() is None:
            os.kill(process.pid, signal.SIGINT)         # all at once, it takes half a second
    ros.close()


@pytest.fixture
def simulate(shared_ros):
    """A function that starts the simulator."""
    master = xmlrpc.client.ServerProxy(shared_ros.env['ROS_MASTER_URI'])

    def start(*parameters, urdf=None, **popen):
        if master.hasParam('/test', '/gazebo')[2]:
            master.deleteParam('/test', '/gazebo')
        master.setParam('/test', '/robot_description', urdf or burger())
        return shared_ros.start('rosrun', 'img_recog', 'pybullet_sim.py', *parameters, **popen)
    return start
