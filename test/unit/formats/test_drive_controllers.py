"""All settings that the parameters of a controller give, and those that they leave."""
import math
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.formats import drive_controllers
from img_recog_helpers.refusals import refusal

JOINTS = 'a', 'b', 'c', 'd', 'l_wheel_joint', 'r_wheel_joint'
CONTROL = '<gazebo><plugin filename="libgazebo_ros_control.so"/></gazebo>'
JOINT_STATES = {'type': 'joint_state_controller/JointStateController'}
DIFF = {'type': 'diff_drive_controller/DiffDriveController', 'left_wheel': 'a',
        'right_wheel': ['b', 'c']}
MECANUM = {'type': 'mecanum_drive_controller/MecanumDriveController',
           'front_left_wheel_joint': 'a', 'front_right_wheel_joint': 'b',
           'back_left_wheel_joint': 'c', 'back_right_wheel_joint': 'd'}
FETCH = {'type': 'robot_controllers/DiffDriveBaseController'}
COMMON = {
    'odometry_source': 'encoder', 'odometry_period_s': 0.02, 'base_frame': 'base_link',
    'odom_frame': 'odom', 'publish_odom_tf': True, 'cmd_vel_timeout': 0.5,
    'command_topic': 'base/cmd_vel', 'odometry_topic': 'base/odom', 'stamped_commands': False}
OF_DIFF = {
    **COMMON, 'left_joint': 'a', 'right_joint': 'b, c', 'wheel_separation_multiplier': 1.0,
    'left_wheel_radius_multiplier': 1.0, 'right_wheel_radius_multiplier': 1.0,
    'wheel_torque': 1e6, 'wheel_acceleration': 0.0}
OF_FETCH = {
    'left_joint': 'l_wheel_joint', 'right_joint': 'r_wheel_joint', 'wheel_separation': 0.37476,
    'wheel_diameter': 2 / 16.5289, 'wheel_torque': 1e6, 'wheel_acceleration': 0.0,
    'max_linear_velocity': 1.0, 'max_angular_velocity': 4.5, 'max_linear_acceleration': 0.75,
    'max_angular_acceleration': 3.0, 'cmd_vel_timeout': 0.25, 'command_topic': 'base/command',
    'odometry_source': 'encoder', 'base_frame': 'base_link', 'publish_odom_tf': True}


def found(controller, others=(), efforts=()):
    """Return the drive of a controller `base`; efforts: the limits of joints, by their names."""
    robot = ElementTree.fromstring('<robot>{}{}</robot>'.format(CONTROL, ''.join(
        '<joint name="{}">{}</joint>'.format(name, dict(efforts).get(name, ''))
        for name in JOINTS)))
    return drive_controllers.find(robot, lambda namespace: {
        'base': controller, **dict(others)}, 0.001)


@pytest.mark.parametrize('controller, wanted', [
    (DIFF, OF_DIFF), (MECANUM, {'drive': 'planar', **COMMON}), (FETCH, OF_FETCH)])
def test_what_controllers_assume(controller, wanted):
    assert found(controller) == (drive_controllers.CONTROL, wanted, ())


@pytest.mark.parametrize('controller, missing', [
    (DIFF, {'left_wheel': 'x'}), (DIFF, {'right_wheel': ['b', 'x']}),
    *((MECANUM, {name + '_wheel_joint': 'x'})
      for name in ('front_left', 'front_right', 'back_left', 'back_right')),
    (FETCH, {'l_wheel_joint': 'x'}), (FETCH, {'r_wheel_joint': 'x'})])
def test_a_controller_of_joints_that_the_robot_does_not_have_is_of_another_robot(
        controller, missing):
    assert found({**controller, **missing}) is None


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


@pytest.mark.parametrize('parameters, wanted', [
    ({'l_wheel_joint': 'a'}, {'left_joint': 'a'}), ({'r_wheel_joint': 'b'}, {'right_joint': 'b'}),
    ({'track_width': 0.5}, {'wheel_separation': 0.5}),
    ({'radians_per_meter': 10}, {'wheel_diameter': 0.2}),
    ({'max_velocity_x': 2}, {'max_linear_velocity': 2}),
    ({'max_velocity_r': 2}, {'max_angular_velocity': 2}),
    ({'max_acceleration_x': 2}, {'max_linear_acceleration': 2}),
    ({'max_acceleration_r': 2}, {'max_angular_acceleration': 2}),
    ({'timeout': 2}, {'cmd_vel_timeout': 2}), ({'publish_tf': False}, {'publish_odom_tf': False})])
def test_parameters_of_fetch(parameters, wanted):
    assert found({**FETCH, **parameters}).values == {**OF_FETCH, **wanted}


@pytest.mark.parametrize('parameters, wanted', [
    ({'left_wheel': ['d', 'a']}, {'left_joint': 'd, a'}), ({'right_wheel': 'd'},
                                                           {'right_joint': 'd'}),
    ({'wheel_separation': 0.5}, {'wheel_separation': 0.5}),
    ({'wheel_radius': 0.05}, {'wheel_diameter': 0.1}),
    ({'wheel_separation_multiplier': 2}, {'wheel_separation_multiplier': 2}),
    ({'wheel_radius_multiplier': 2}, {'left_wheel_radius_multiplier': 2,
                                      'right_wheel_radius_multiplier': 2}),
    ({'left_wheel_radius_multiplier': 2}, {'left_wheel_radius_multiplier': 2}),
    ({'right_wheel_radius_multiplier': 2}, {'right_wheel_radius_multiplier': 2}),
    ({'publish_rate': 100}, {'odometry_period_s': 0.01}), ({'publish_rate': 0}, {}),
    ({'publish_rate': -5}, {}), ({'publish_rate': 0.5}, {'odometry_period_s': 2.0}),
    ({'base_frame_id': '/Xb/'}, {'base_frame': 'Xb'}), ({'odom_frame_id': '/X/'},
                                                        {'odom_frame': 'X'}),
    ({'base_frame_id': '/'}, {}),
    ({'base_frame_id': 5}, {}), ({'odom_frame_id': 'map'}, {'odom_frame': 'map'}),
    ({'odom_frame_id': ''}, {}), ({'enable_odom_tf': False}, {'publish_odom_tf': False}),
    ({'cmd_vel_timeout': 2}, {'cmd_vel_timeout': 2}), ({'cmd_vel_timeout': '2'},
                                                       {'cmd_vel_timeout': 2}),
    ({'use_stamped_vel': True}, {'stamped_commands': True}), ({'linear': 5}, {}),
    ({'linear': {'x': {'max_velocity': 3}}}, {}),
    ({'linear': {'x': {'has_velocity_limits': True}}},
     {'max_linear_velocity': 0.0, 'min_linear_velocity': 0.0}),
    ({'linear': {'x': {'has_acceleration_limits': True, 'max_acceleration': 3,
                       'min_acceleration': -2}}},
     {'max_linear_acceleration': 3, 'min_linear_acceleration': -2}),
    ({'angular': {'z': {'has_velocity_limits': True, 'max_velocity': 3, 'min_velocity': -2}}},
     {'max_angular_velocity': 3, 'min_angular_velocity': -2})])
def test_parameters_of_diff_drive_controller(parameters, wanted):
    assert found({**DIFF, **parameters}).values == {**OF_DIFF, **wanted}


@pytest.mark.parametrize('parameters, wanted', [
    ({'wheel_radius': float('inf')}, 'wheel_radius: got inf, expected a finite number'),
    ({'linear': {'x': {'has_velocity_limits': True, 'max_velocity': [1]}}},
     'linear/x/max_velocity: got [1], expected a finite number'),
    ({'right_wheel': []},
     'right_wheel: got [], expected the name of a joint, or a list of names'),
    ({'wheel_separation': 'nan'}, "wheel_separation: got 'nan', expected a finite number"),
    ({'left_wheel': None},
     'left_wheel: got None, expected the name of a joint, or a list of names'),
    ({'left_wheel': ['a', 3]},
     "left_wheel: got ['a', 3], expected the name of a joint, or a list of names")])
def test_refuses_parameters(parameters, wanted):
    assert refusal(found, {**DIFF, **parameters}) == 'parameter base/' + wanted


@pytest.mark.parametrize('effort, torque', [
    ('7.5', 7.5), ('0.5', 0.5), ('0', 1e6), ('-1', 1e6), ('2e6', 1e6), ('nan', 1e6), ('x', 1e6)])
@pytest.mark.parametrize('controller, joints', [(DIFF, 'ac'), (FETCH, JOINTS[4:])])
def test_the_least_effort_of_a_wheel_counts(controller, joints, effort, torque):
    for weak in joints:
        efforts = {name: '<limit effort="9e5"/>' for name in JOINTS}
        efforts[weak] = '<limit effort="{}"/>'.format(effort)
        assert found(controller, efforts=efforts).values['wheel_torque'] == min(torque, 9e5)


@pytest.mark.parametrize('rate, period', [
    ({'publish_rate': 50}, {'joint_states_period_s': 0.02}),
    ({}, {'joint_states_period_s': 0.001})])
def test_joint_states_have_a_rate_of_their_own(rate, period):
    others = {'arm': {'type': 'a/Arm', 'publish_rate': 10}, 'joints': {**JOINT_STATES, **rate}}
    assert found(DIFF, others).values == OF_DIFF
    assert drive_controllers.joint_states(
        ElementTree.fromstring('<robot>{}</robot>'.format(CONTROL)), lambda _: others,
        0.001) == period
    assert found(DIFF, others).problems == ('controller arm (a/Arm)',)


@pytest.mark.parametrize('controller', [DIFF, MECANUM])
@pytest.mark.parametrize('path, is_said', [
    (('linear', 'x'), True), (('angular', 'z'), True), (('linear', 'y'), False)])
def test_limits_of_jerk_are_not_simulated(controller, path, is_said):
    limits = {path[0]: {path[1]: {'has_jerk_limits': True}}}
    assert found({**controller, **limits}).problems == (
        'jerk limits of controller base',) * is_said


def test_of_two_drives_the_second_is_not_simulated():
    read = found(DIFF, {'second': FETCH, 'third': {**DIFF, 'left_wheel': 'x'}})
    assert read.values['left_joint'] == 'a'
    assert read.problems == (
        'controller second (robot_controllers/DiffDriveBaseController)',
        'controller third (diff_drive_controller/DiffDriveController)')


def test_where_none_drives_all_but_the_joint_states_are_not_simulated():
    robot = ElementTree.fromstring('<robot><joint name="c"/></robot>')
    assert drive_controllers.not_simulated(
        robot, {'a': DIFF, 'b': {'type': 'a/Arm'}, 'c': JOINT_STATES, 'd': FETCH}) == (
            'controller a (diff_drive_controller/DiffDriveController: the robot has no joint a, '
            'b)', 'controller b (a/Arm)', 'controller d (robot_controllers/DiffDriveBaseController'
            ': the robot has no joint l_wheel_joint, r_wheel_joint)')


@pytest.mark.parametrize('namespace, before', [('', ''), ('r/s', 'r/s/')])
def test_controllers_among_parameters(namespace, before):
    parameters = {'b': DIFF, 'a': FETCH, 'c': {'type': 'plain'}, 'd': 3, 'e': {}, 'f': {'type': 3}}
    assert list(drive_controllers.among(parameters, namespace).items()) == [
        (before + 'a', FETCH), (before + 'b', DIFF)]


@pytest.mark.parametrize('parameters', [None, 3, {}])
def test_no_controllers_among_parameters(parameters):
    assert drive_controllers.among(parameters, 'r') == {}
