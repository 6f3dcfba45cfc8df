"""The controllers that a robot can have: where their parameters are, and what they are called."""
from functools import partial

import pytest

from img_recog.formats import drive_controllers, urdf
from img_recog.nodes.gazebo import robot_reader
from img_recog.simulation.simulation_settings import Names
from img_recog_helpers.wheeled import plugin, robot

DRIVE = {'type': 'diff_drive_controller/DiffDriveController', 'left_wheel': 'left'}
OTHER = {**DRIVE, 'left_wheel': 'another'}


AT_ROOT = {'/': {'base': DRIVE, 'gazebo': {'type': 'x'}, 'robot_description': '<robot/>',
                 'other': {'base': OTHER}}}
OF_A_PLUGIN = {'/': {'base': OTHER}, '/husky': {'base': DRIVE}}
OF_A_ROBOT = {'/': {'base': OTHER, 'arm': OTHER}, '/r1': {'base': DRIVE},
              '/r1/wheels': {'base': DRIVE}}


# the parameters, the namespace in the tags of the plugin, that of the robot, and what is found
@pytest.mark.parametrize('server, space, namespace, found', [
    *((AT_ROOT, space, '', {'base': DRIVE}) for space in (None, '', '/')),
    (OF_A_PLUGIN, '/husky', '', {'husky/base': DRIVE}),
    # that of the robot, which its topics get anyway
    (OF_A_PLUGIN, 'husky', 'husky', {'base': DRIVE}),
    # those of a robot count more than those for all
    (OF_A_ROBOT, '/', 'r1', {'base': DRIVE, 'arm': OTHER}),
    (OF_A_ROBOT, '/', 'r2', {'base': OTHER, 'arm': OTHER}),
    (OF_A_ROBOT, 'wheels', 'r1', {'wheels/base': DRIVE}),
    ({'/': None}, None, '', {}), ({}, None, '', {})])
def test_the_controllers_of_a_robot(monkeypatch, server, space, namespace, found):
    monkeypatch.setattr('rospy.get_namespace', lambda: '/')
    monkeypatch.setattr('img_recog.ros.parameters.value', server.get)
    tags = {} if space is None else {'robotNamespace': space}
    for library, expected in (('gazebo_ros_control', found), ('gazebo_ros_planar_move', {})):
        assert drive_controllers.of_robot(
            urdf.root_of(robot(plugin(library, **tags))),
            partial(robot_reader.read_controllers, Names(namespace))) == expected
