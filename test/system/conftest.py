"""Fixtures for tests that run whole processes."""
import copy
import os
import signal

import pytest

from img_recog_testing.processes import Ros
from img_recog_testing.simulator_tools import burger


@pytest.fixture
def ros(tmp_path):
    """A separate master address for one test."""
    ros = Ros(tmp_path)
    yield ros
    ros.close()


@pytest.fixture(scope='module')
def roscore(tmp_path_factory):
    """A running master, shared by the tests of one module."""
    ros = Ros(tmp_path_factory.mktemp('roscore'))
    core = ros.start('roscore', '-p', ros.port)
    core.wait_output('started core service')
    yield ros
    ros.close()


@pytest.fixture
def shared_ros(roscore):
    """The master of a module; processes that a test starts are stopped after it."""
    ros = copy.copy(roscore)
    ros._processes = []
    yield ros
    for process in ros._processes:
        if process._popen.poll() is None:
            os.kill(process.pid, signal.SIGINT)         # in parallel: each takes half a second
    ros.close()


@pytest.fixture
def simulate(shared_ros):
    """A function that starts the simulator."""
    def start(*parameters, urdf=None, **popen):
        shared_ros.set_parameters('/gazebo')
        shared_ros.set_parameters('/robot_description', urdf or burger())
        return shared_ros.start('rosrun', 'img_recog', 'pybullet_sim.py', *parameters, **popen)
    return start
