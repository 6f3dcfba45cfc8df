"""The controllers that a robot can have: where their parameters are, and what they are called."""
from functools import partial

import pytest

from img_recog.formats import drive_controllers, urdf
from img_recog.nodes.gazebo import controllers
from img_recog.simulation.names import Names
from img_recog_helpers.wheeled import plugin, robot

DRIVE = {'type': 'diff_drive_controller/DiffDriveController', 'left_wheel': 'left'}
OTHER = {**DRIVE, 'left_wheel': 'another'}


@pytest.fixture
def read(monkeypatch):
    """A function that returns what a robot finds on a parameter server."""
    def read(server, robot_namespace=None, namespace='', library='gazebo_ros_control'):
        tags = {} if robot_namespace is None else {'robotNamespace': robot_namespace}
        monkeypatch.setattr('rospy.get_namespace', lambda: '/')
        monkeypatch.setattr('img_recog.ros.parameters.value', server.get)
        return drive_controllers.of_robot(urdf.root_of(robot(plugin(library, **tags))),
                                          partial(controllers.read, Names(namespace)))
    return read


@pytest.mark.parametrize('space', [None, '', '/'])
def test_those_of_a_single_robot_are_at_the_root(read, space):
    assert read({'/': {'base': DRIVE, 'gazebo': {'type': 'x'}, 'robot_description': '<robot/>',
                       'other': {'base': OTHER}}}, space) == {'base': DRIVE}


def test_those_in_the_namespace_of_the_plugin(read):
    server = {'/': {'base': OTHER}, '/husky': {'base': DRIVE}}
    assert read(server, '/husky') == {'husky/base': DRIVE}
    # that of the robot, which its topics get anyway
    assert read(server, 'husky', 'husky') == {'base': DRIVE}


def test_those_in_the_namespace_of_a_robot_count_more_than_those_for_all(read):
    server = {'/': {'base': OTHER, 'arm': OTHER}, '/r1': {'base': DRIVE},
              '/r1/wheels': {'base': DRIVE}}
    assert read(server, '/', 'r1') == {'base': DRIVE, 'arm': OTHER}
    assert read(server, '/', 'r2') == {'base': OTHER, 'arm': OTHER}
    assert read(server, 'wheels', 'r1') == {'wheels/base': DRIVE}


def test_a_robot_that_runs_no_controllers_has_none(read):
    assert read({'/': {'base': DRIVE}}, library='gazebo_ros_planar_move') == {}


def test_there_may_be_none(read):
    assert read({'/': None}) == read({}) == {}
