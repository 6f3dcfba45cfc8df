"""What the plugins of a URDF, and the parameters of controllers, say about the drive."""
import pytest

from img_recog.formats import drive_controllers, drive_tags, urdf
from img_recog.report import Report
from img_recog.settings import from_mapping
from img_recog.simulation.sensors.joint_states import JointStateSettings
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.simulation_settings import DriveSettings
from img_recog_helpers.wheeled import assembled, controllers, plugin, robot, source

CONTROL = plugin('gazebo_ros_control')


def values(*elements, given=()):
    """Return the settings that a URDF gives."""
    return source(robot(''.join(elements), rows=(0.15, -0.15)), given).tag_values


@pytest.mark.parametrize('library', ['gazebo_ros_diff_drive', 'gazebo_ros_skid_steer_drive'])
def test_what_plugins_for_wheels_assume(library):
    found = values(plugin(library))
    drive, odometry, joints = (from_mapping(each, found) for each in (
        DriveSettings, OdometrySettings, JointStateSettings))
    assert (drive.wheel_torque, drive.wheel_acceleration, drive.drive_period_s) == (5.0, 0.0, 0.01)
    assert (odometry.odometry_period_s, joints.joint_states_period_s) == (0.01, 0.01)


def find(element, given):
    return drive_tags.find(urdf.root_of(robot(element)), 0.001, Report(), lambda namespace: given)


@pytest.mark.parametrize('library', ['gazebo_ros_control', 'fetch_gazebo_plugin'])
def test_plugins_that_run_controllers(library):
    found = find(plugin(library), controllers())
    assert found.values['left_joint'] == 'left_0_joint'
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
     'controller car (ackermann_steering_controller/AckermannSteeringController)'),
    (CONTROL, {'base': {**controllers()['base'], 'left_wheel': 'l'}},
     'controller base (diff_drive_controller/DiffDriveController: the robot has no joint l)'),
    (plugin('gazebo_ros_tricycle_drive'), {}, 'it has: plugin libgazebo_ros_tricycle_drive.so;'),
    ('', {}, 'it does not drive, as it has no drive that is simulated;')])
def test_a_robot_without_a_drive_that_is_simulated_is_told_so_in_one_line(elements, given, wanted):
    warnings = assembled(robot(elements), given).world.report.lines()
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
