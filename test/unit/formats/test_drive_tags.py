"""What the plugins of a URDF, and the parameters of controllers, say about the drive."""
import pytest

from img_recog.formats import drive_controllers, drive_tags, urdf
from img_recog.settings import from_mapping
from img_recog.simulation.sensors.joint_states import JointStateSettings
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.simulation_settings import DriveSettings
from img_recog_helpers import parsed
from img_recog_helpers.wheeled import assembled, controllers, plugin, robot, source

CORNERS = {'leftFrontJoint': 'left_0_joint', 'leftRearJoint': 'left_1_joint',
           'rightFrontJoint': 'right_0_joint', 'rightRearJoint': 'right_1_joint'}
CONTROL = plugin('gazebo_ros_control')


def values(*elements, given=()):
    """Return the settings that a URDF gives."""
    return source(robot(''.join(elements), rows=(0.15, -0.15)), given).tag_values


def differing(found, **wanted):
    return {name: found.get(name) for name in wanted if found.get(name) != wanted[name]}


def test_skid_steering():
    found = values(plugin(
        'gazebo_ros_skid_steer_drive', **CORNERS, wheelSeparation='0.5', wheelDiameter='0.2',
        torque='20', commandTopic='/robot/cmd_vel', odometryTopic='odometry', updateRate='50',
        odometryFrame='/map', robotBaseFrame='/base_link', broadcastTF='1'))
    assert not differing(
        found, left_joint='left_0_joint, left_1_joint', wheel_separation=0.5, wheel_diameter=0.2,
        right_joint='right_0_joint, right_1_joint', wheel_torque=20.0,
        command_topic='robot/cmd_vel', odometry_topic='odometry', odometry_period_s=0.02,
        joint_states_period_s=0.02, odom_frame='map', base_frame='base_link',
        publish_odom_tf=True)


@pytest.mark.parametrize('corners, left, right', [
    ({}, 'left_front_joint, left_rear_joint', 'right_front_joint, right_rear_joint'),
    ({'leftRearJoint': 'left_1_joint', 'rightFrontJoint': 'r', 'rightRearJoint': 'r'},
     'left_front_joint, left_1_joint', 'r')])
def test_the_corners_of_skid_steering(corners, left, right):
    found = values(plugin('gazebo_ros_skid_steer_drive', **corners))
    assert (found['left_joint'], found['right_joint']) == (left, right)
    assert found['publish_odom_tf'] is False and not set(CORNERS) & set(found)


@pytest.mark.parametrize('library, more, wanted', [
    ('gazebo_ros_planar_move', {'odometryRate': '50', 'cmdTimeout': '-1'},
     {'odometry_period_s': 0.02, 'odometry_source': None, 'cmd_vel_timeout': None}),
    ('gazebo_ros_planar_move', {'cmdTimeout': '0.5'},
     {'odometry_period_s': 0.05, 'cmd_vel_timeout': 0.5}),
    ('hector_gazebo_ros_force_based_move', {'publishOdometryTf': '0', 'cmdVelTimeOut': '0.25'},
     {'odometry_source': 'encoder', 'publish_odom_tf': False, 'cmd_vel_timeout': 0.25}),
    ('gazebo_ros_planar_move', {'publishTF': '0', 'odometryRate': '20'},
     {'publish_odom_tf': False, 'odometry_period_s': 0.05}),
    ('gazebo_ros_planar_move', {'publish_odom_tf': '0', 'publish_rate': '50'},
     {'publish_odom_tf': False, 'odometry_period_s': 0.02}),
    ('gazebo_ros_force_based_move', {'commandWatchdog': '0.75', 'odometryRate': '50'},
     {'cmd_vel_timeout': 0.75, 'odometry_period_s': 0.02, 'publish_odom_tf': None}),
    ('gazebo_ros_force_based_move', {}, {'odometry_period_s': 0.05})])
def test_bases_that_move_themselves(library, more, wanted):
    found = values(plugin(library, commandTopic='go', odometryFrame='map', **more))
    assert not differing(found, drive='planar', command_topic='go', odom_frame='map', **wanted)


def test_several_pairs_of_wheels_in_ros_2():
    tags = ('<num_wheel_pairs>2</num_wheel_pairs><left_joint>a</left_joint><left_joint>/b'
            '</left_joint><right_joint>c</right_joint><right_joint>d</right_joint>'
            '<wheel_diameter>0.1</wheel_diameter><wheel_diameter>{}</wheel_diameter>')
    urdf = ('<robot><gazebo><plugin filename="libgazebo_ros_diff_drive.so">{}</plugin></gazebo>'
            '</robot>')
    for diameter, problems in (('0.1', []), ('0.2', ['another <wheel_diameter> of a pair of '
                                                     'wheels'])):
        found = parsed.tags(urdf.format(tags.format(diameter)),
                            drive=drive_tags.DIFF_DRIVE.tags)
        assert found.values == {'left_joint': 'a, b', 'right_joint': 'c, d',
                                'wheel_diameter': 0.1}
        assert found.not_simulated == problems


@pytest.mark.parametrize('names', [
    ('commandTopic', 'odometryTopic', 'odometryFrame', 'robotBaseFrame', 'odometrySource',
     'publishOdomTF', 'leftJoint', 'rightJoint', 'wheelSeparation', 'wheelDiameter', 'wheelTorque',
     'wheelAcceleration', 'updateRate'),
    ('commandTopic', 'odometryTopic', 'odometry_frame', 'robot_base_frame', 'odometry_source',
     'publish_odom_tf', 'left_joint', 'right_joint', 'wheel_separation', 'wheel_diameter',
     'max_wheel_torque', 'max_wheel_acceleration', 'update_rate')])
def test_every_name_of_a_tag(names):
    given = dict(zip(names, ('go', 'at', 'map', 'base', 'encoder', '0', 'l', 'r', '2', '3', '4',
                             '5', '50')))
    assert values(plugin('gazebo_ros_diff_drive', **given)) == {
        'command_topic': 'go', 'odometry_topic': 'at', 'odom_frame': 'map', 'base_frame': 'base',
        'odometry_source': 'encoder', 'publish_odom_tf': False, 'left_joint': 'l',
        'right_joint': 'r', 'wheel_separation': 2.0, 'wheel_diameter': 3.0, 'wheel_torque': 4.0,
        'wheel_acceleration': 5.0, 'drive_period_s': 0.02, 'odometry_period_s': 0.02,
        'joint_states_period_s': 0.02}


@pytest.mark.parametrize('library', ['gazebo_ros_diff_drive', 'gazebo_ros_skid_steer_drive'])
def test_what_plugins_for_wheels_assume(library):
    found = values(plugin(library))
    drive, odometry, joints = (from_mapping(each, found) for each in (
        DriveSettings, OdometrySettings, JointStateSettings))
    assert (drive.wheel_torque, drive.wheel_acceleration, drive.drive_period_s) == (5.0, 0.0, 0.01)
    assert (odometry.odometry_period_s, joints.joint_states_period_s) == (0.01, 0.01)


def test_messages_of_a_drive_can_be_fewer_than_its_updates():
    found = values(plugin('gazebo_ros_diff_drive', updateRate='100', odometryRate='30'))
    assert not differing(found, drive_period_s=0.01, odometry_period_s=0.033,
                         joint_states_period_s=0.033)


def test_kobuki():
    assumed = {'odometry_source': 'encoder', 'publish_odom_tf': False,
               'base_frame': 'base_footprint', 'command_topic': 'mobile_base/commands/velocity'}
    assert values(plugin('gazebo_ros_kobuki')) == assumed
    assert values(plugin(
        'gazebo_ros_kobuki', left_wheel_joint_name='l', right_wheel_joint_name='r',
        wheel_separation='2', wheel_diameter='3', torque='4', velocity_command_timeout='5',
        publish_tf='1')) == {
            **assumed, 'left_joint': 'l', 'right_joint': 'r', 'wheel_separation': 2.0,
            'wheel_diameter': 3.0, 'wheel_torque': 4.0, 'cmd_vel_timeout': 5.0,
            'publish_odom_tf': True}


def find(element, given):
    return drive_tags.find(urdf.root_of(robot(element)), 0.001, lambda namespace: given)


@pytest.mark.parametrize('library', ['gazebo_ros_control', 'fetch_gazebo_plugin'])
def test_plugins_that_run_controllers(library):
    found = find(plugin(library), controllers())
    assert found.values['left_joint'] == 'left_0_joint' and found.problems == ()
    assert find(plugin(library), {}) is None
    assert find(plugin('gazebo_ros_p3d'), controllers()) is None


def test_the_first_drive_counts_and_a_plugin_more_than_a_controller():
    planar, skid = plugin('gazebo_ros_planar_move'), plugin('gazebo_ros_skid_steer_drive')
    assert values(planar, skid)['drive'] == 'planar' and 'drive' not in values(skid, planar)
    assert values(CONTROL, planar, given=controllers())['drive'] == 'planar'


@pytest.mark.parametrize('given', [{}, {'base': controllers()['base']}])
def test_no_controller_without_the_plugin_that_runs_them(given):
    assert 'left_joint' not in values(given=given)


@pytest.mark.parametrize('elements, given, wanted', [
    (CONTROL, {}, 'it has: plugin libgazebo_ros_control.so;'),
    (CONTROL, {'car': {'type': 'ackermann_steering_controller/AckermannSteeringController'}},
     'controller car (ackermann_steering_controller/AckermannSteeringController);'),
    (CONTROL, {'base': {**controllers()['base'], 'left_wheel': 'l'}},
     'controller base (diff_drive_controller/DiffDriveController: the robot has no joint l);'),
    (plugin('gazebo_ros_tricycle_drive'), {}, 'it has: plugin libgazebo_ros_tricycle_drive.so;'),
    ('', {}, 'it does not drive, as it has no drive that is simulated;')])
def test_a_robot_without_a_drive_that_is_simulated_is_told_so_in_one_line(elements, given, wanted):
    warnings = assembled(robot(elements), given).warnings
    line, = [each for each in warnings if 'does not drive' in each]
    assert line.startswith('robot.urdf: it does not drive, as it has no drive that is simulated')
    assert wanted in line and 'set left_joint and right_joint' in line
    assert 'diff_drive_controller/DiffDriveController' in line


@pytest.mark.parametrize('namespace, wanted', [
    ('', ''), ('/', ''), ('/husky/', 'husky'), (' a/b ', 'a/b'), ('/X1/', 'X1')])
def test_the_namespace_of_controllers(namespace, wanted):
    asked = []
    drive_controllers.of_robot(urdf.root_of(robot(plugin(
        'gazebo_ros_control', robotNamespace=namespace))), asked.append)
    assert asked == [wanted]


def test_no_namespace_where_there_are_no_controllers():
    asked = []
    root = urdf.root_of(robot(plugin('gazebo_ros_planar_move')))
    assert drive_controllers.of_robot(root, asked.append) == {} and asked == []
