"""Joints that controllers hold, the efforts of their wheels, and which parameters are theirs."""
import math
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.formats import drive_controllers
from img_recog.report import Report

JOINTS = 'a', 'b', 'c', 'd', 'l_wheel_joint', 'r_wheel_joint'
CONTROL = '<gazebo><plugin filename="libgazebo_ros_control.so"/></gazebo>'
DIFF = {'type': 'diff_drive_controller/DiffDriveController', 'left_wheel': 'a',
        'right_wheel': ['b', 'c']}
FETCH = {'type': 'robot_controllers/DiffDriveBaseController'}


def found(controller, efforts):
    """Return the drive of a controller `base`; efforts: the limits of joints, by their names."""
    robot = ElementTree.fromstring('<robot>{}{}</robot>'.format(CONTROL, ''.join(
        '<joint name="{}">{}</joint>'.format(name, efforts.get(name, ''))
        for name in JOINTS)))
    return drive_controllers.find(robot, lambda namespace: {'base': controller}, 0.001, Report())


TRANSMISSION = ('<transmission><joint name="a">{}</joint><actuator>{}</actuator></transmission>'
                '<joint name="a"><limit effort="7"/></joint>')
INTERFACE = '<hardwareInterface>{}JointInterface</hardwareInterface>'
ARM = {'type': 'effort_controllers/JointTrajectoryController', 'joints': ['b', 'a']}


@pytest.mark.parametrize('plugin, kind, controller, wanted', [
    (CONTROL, 'hardware_interface/Position', {}, {'a': math.inf}),
    (CONTROL, 'Position', {}, {'a': math.inf}),
    (CONTROL, 'hardware_interface/Velocity', {}, {'a': 7.0}),
    (CONTROL, 'hardware_interface/Effort', {}, {}),
    (CONTROL, 'hardware_interface/Effort', {**ARM, 'joints': ['b']}, {}),
    (CONTROL, 'hardware_interface/Effort', ARM, {'a': math.inf}),
    (CONTROL, 'hardware_interface/Effort', {**ARM, 'joint': 'a'}, {'a': math.inf}),
    ('', 'hardware_interface/Position', {}, {})])
@pytest.mark.parametrize('place', [(INTERFACE, ''), ('', INTERFACE)], ids=['joint', 'actuator'])
def test_joints_that_ros_control_holds(plugin, kind, controller, wanted, place):
    robot = ElementTree.fromstring('<robot>{}{}</robot>'.format(plugin, TRANSMISSION.format(
        *(each.format(kind) for each in place))))
    assert drive_controllers.held(robot, lambda namespace: {'arm': controller}) == wanted


@pytest.mark.parametrize('effort, torque', [
    ('7.5', 7.5), ('0.5', 0.5), ('0', 1e6), ('-1', 1e6), ('2e6', 1e6), ('nan', 1e6), ('x', 1e6)])
@pytest.mark.parametrize('controller, joints', [(DIFF, 'ac'), (FETCH, JOINTS[4:])])
def test_the_least_effort_of_a_wheel_counts(controller, joints, effort, torque):
    for weak in joints:
        efforts = {name: '<limit effort="9e5"/>' for name in JOINTS}
        efforts[weak] = '<limit effort="{}"/>'.format(effort)
        assert found(controller, efforts).values['wheel_torque'] == min(torque, 9e5)


@pytest.mark.parametrize('namespace, before', [('', ''), ('r/s', 'r/s/')])
def test_controllers_among_parameters(namespace, before):
    parameters = {'b': DIFF, 'a': FETCH, 'c': {'type': 'plain'}, 'd': 3, 'e': {}, 'f': {'type': 3}}
    assert list(drive_controllers.among(parameters, namespace).items()) == [
        (before + 'a', FETCH), (before + 'b', DIFF)]


@pytest.mark.parametrize('parameters', [None, 3, {}])
def test_no_controllers_among_parameters(parameters):
    assert drive_controllers.among(parameters, 'r') == {}
