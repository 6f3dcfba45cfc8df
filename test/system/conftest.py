"""Fixtures for tests that run whole processes."""
import os

import pytest

from img_recog_helpers.processes import Ros
from img_recog_helpers.simulator_tools import burger


@pytest.fixture
def ros(request, tmp_path):
    """A separate master address for one test; the master of its module if that uses shared_ros."""
    if 'shared_ros' in request.fixturenames:
        yield request.getfixturevalue('shared_ros')
    else:
        with Ros(tmp_path) as ros:
            yield ros


@pytest.fixture(scope='module')
def roscore(tmp_path_factory):
    """A running master, shared by the tests of one module."""
    with Ros(tmp_path_factory.mktemp('roscore')) as ros:
        ros.start_master()
        yield ros


@pytest.fixture
def shared_ros(roscore):
    """The master of a module; processes that a test starts are stopped after it."""
    with roscore.beside() as ros:
        yield ros


@pytest.fixture
def simulate(shared_ros):
    """A function that starts the simulator."""
    def start(*parameters, urdf=None, **popen):
        shared_ros.set_parameters('/gazebo')
        shared_ros.set_parameters('/robot_description', urdf or burger())
        return shared_ros.start_node('pybullet_sim.py', *parameters, **popen)
    return start


@pytest.fixture
def display(ros, tmp_path):
    """A virtual display; ros.env has its name. Returns the file in which what it shows is kept."""
    reader, writer = os.pipe()
    # without -noreset it ends the connections of new clients when the last one has gone
    server = ros.start('Xvfb', '-displayfd', writer, '-noreset', '-screen', '0', '1100x800x24',
                       '-nolisten', 'tcp', '-fbdir', tmp_path, pass_fds=[writer])
    os.close(writer)
    with os.fdopen(reader) as file:
        number = file.readline().strip()
    assert number, server.output
    ros.env['DISPLAY'] = ':' + number
    return tmp_path / 'Xvfb_screen0'
