"""The drives that the plugins of a URDF stand for: a row each.

drive_controllers.py has those of controllers of ros_control. Other paths are the names that the
plugins of gazebo_plugins have in ROS 2.
"""
import xml.etree.ElementTree as ElementTree
from typing import List, Optional, Sequence

from img_recog.formats import drive_controllers
from img_recog.formats.drive_controllers import FindControllers
from img_recog.formats.gazebo_tags import (CORNERS, FLAG, NAME, NAMES, NUMBER, POSITIVE, RATE,
                                           TOPIC, DriveDescription, Row, Tags, choice, is_of,
                                           values_in)
from img_recog.model import PLANAR, Model
from img_recog.report import Report

_WORLD, _ENCODER = 'world', 'encoder'
_TOPICS = (
    Row('command_topic', TOPIC, 'plugin', 'commandTopic'),
    Row('odometry_topic', TOPIC, 'plugin', 'odometryTopic'),
    Row('odom_frame', NAME, 'plugin', 'odometryFrame', 'odometry_frame'),
    Row('base_frame', NAME, 'plugin', 'robotBaseFrame', 'robot_base_frame'))
# in Gazebo one plugin sets the motors and publishes odometry and joint states
_UPDATE_RATE = (
    Row('drive_period_s', RATE, 'plugin', 'updateRate', 'update_rate'),
    Row('odometry_period_s', RATE, 'plugin', 'updateRate', 'update_rate'),
    Row('joint_states_period_s', RATE, 'plugin', 'updateRate', 'update_rate'))


def _other_sizes(plugin: ElementTree.Element) -> List[str]:
    """Return the sizes of pairs of wheels that are not those of the first pair."""
    return ['another <{}> of a pair of wheels'.format(tag)
            for tag in ('wheel_separation', 'wheel_diameter')
            if len({(each.text or '').strip() for each in plugin.findall(tag)}) > 1]


DIFF_DRIVE = DriveDescription(Tags(('gazebo_ros_diff_drive',), (
    Row('left_joint', NAMES, 'plugin', 'leftJoint', 'left_joint'),
    Row('right_joint', NAMES, 'plugin', 'rightJoint', 'right_joint'),
    Row('wheel_separation', NUMBER, 'plugin', 'wheelSeparation', 'wheel_separation'),
    Row('wheel_diameter', NUMBER, 'plugin', 'wheelDiameter', 'wheel_diameter'),
    Row('wheel_torque', NUMBER, 'plugin', 'max_wheel_torque'),
    # <torque> is the name in the plugin's first versions
    Row('wheel_torque', NUMBER, 'plugin', 'wheelTorque', 'torque'),
    Row('wheel_acceleration', NUMBER, 'plugin', 'wheelAcceleration', 'max_wheel_acceleration'),
    # the numbers are those of OdomSource in the plugin
    Row('odometry_source', choice('world or encoder', {
        _WORLD: _WORLD, '1': _WORLD, _ENCODER: _ENCODER, '0': _ENCODER}), 'plugin',
        'odometrySource', 'odometry_source'),
    Row('publish_odom_tf', FLAG, 'plugin', 'publishOdomTF', 'publish_odom_tf'),
    *_TOPICS, *_UPDATE_RATE,
    # of this simulator alone: of messages, where they are fewer than updates of the motors
    Row('odometry_period_s', RATE, 'plugin', 'odometryRate'),
    Row('joint_states_period_s', RATE, 'plugin', 'odometryRate')), not_simulated=_other_sizes),
    {'left_joint': 'left_joint', 'right_joint': 'right_joint'})

PLUGINS = (
    DIFF_DRIVE,
    DriveDescription(Tags(('gazebo_ros_skid_steer_drive',), (
        *(Row(corner, NAME, 'plugin', corner) for pair in CORNERS.values() for corner in pair),
        Row('wheel_separation', NUMBER, 'plugin', 'wheelSeparation'),
        Row('wheel_diameter', NUMBER, 'plugin', 'wheelDiameter'),
        Row('wheel_torque', NUMBER, 'plugin', 'torque'),
        Row('publish_odom_tf', FLAG, 'plugin', 'broadcastTF'), *_TOPICS, *_UPDATE_RATE)),
        # the names of the plugin
        {'leftFrontJoint': 'left_front_joint', 'leftRearJoint': 'left_rear_joint',
         'rightFrontJoint': 'right_front_joint', 'rightRearJoint': 'right_rear_joint',
         'publish_odom_tf': False}),
    DriveDescription(Tags(('gazebo_ros_planar_move',), (
        Row('odometry_period_s', RATE, 'plugin', 'odometryRate', 'publish_rate'),
        Row('publish_odom_tf', FLAG, 'plugin', 'publishTF', 'publish_odom_tf'),
        Row('cmd_vel_timeout', POSITIVE, 'plugin', 'cmdTimeout'), *_TOPICS)),
        {'drive': PLANAR, 'odometry_period_s': 0.05}),
    # of hector_gazebo_plugins, and those that others derived from it
    DriveDescription(Tags(('force_based_move',), (
        Row('odometry_period_s', RATE, 'plugin', 'odometryRate'),
        Row('publish_odom_tf', FLAG, 'plugin', 'publishOdometryTf'),
        Row('cmd_vel_timeout', POSITIVE, 'plugin', 'cmdVelTimeOut', 'commandWatchdog'), *_TOPICS)),
        {'drive': PLANAR, 'odometry_period_s': 0.05, 'odometry_source': _ENCODER}),
    # of kobuki_gazebo_plugins; its frames and topics are in its code
    DriveDescription(Tags(('gazebo_ros_kobuki',), (
        Row('left_joint', NAME, 'plugin', 'left_wheel_joint_name'),
        Row('right_joint', NAME, 'plugin', 'right_wheel_joint_name'),
        Row('wheel_separation', NUMBER, 'plugin', 'wheel_separation'),
        Row('wheel_diameter', NUMBER, 'plugin', 'wheel_diameter'),
        Row('wheel_torque', NUMBER, 'plugin', 'torque'),
        Row('cmd_vel_timeout', POSITIVE, 'plugin', 'velocity_command_timeout'),
        Row('publish_odom_tf', FLAG, 'plugin', 'publish_tf')),
        not_simulated=lambda _: ('bumpers, cliff sensors and inertial unit of plugin '
                                 'libgazebo_ros_kobuki.so',)),
        {'odometry_source': _ENCODER, 'publish_odom_tf': False,
         'base_frame': 'base_footprint', 'command_topic': 'mobile_base/commands/velocity'}))

# Ackermann steering, tricycles and legs are not
ADVICE = (
    'simulated are differential, skid-steered and planar drives: {}, and of controllers whose '
    'parameters are loaded before the node starts, {}; else set left_joint and right_joint to the '
    'joints of its wheels'.format(
        ', '.join('lib' + row.tags.plugins[0] for row in PLUGINS[:3]),
        ', '.join(drive_controllers.TYPES)))


def find(robot: ElementTree.Element, step_s: float, report: Report,
         controllers: FindControllers = drive_controllers.none) -> Optional[DriveDescription]:
    """Return what says how the robot of a URDF's <robot> is driven, None if nothing does.

    step_s: of the physics. report: gets what is not simulated of controllers where no plugin
    drives. controllers: returns those of ros_control that it can have. A plugin
    that drives by itself counts more than a controller; of two, the first counts.
    Raises SimulationError when a tag or a controller has a wrong value.
    """
    return _of_plugins(robot.findall('gazebo/plugin'), step_s) or drive_controllers.find(
        robot, controllers, step_s, report)


def of_model(model: Model, step_s: float) -> Optional[DriveDescription]:
    """Return the drive of a model of an SDF, None for one that does not drive; errors as for
    `find`.
    """
    return _of_plugins(_plugins(model), step_s)


def is_driven(model: Model) -> bool:
    """Return whether a model of an SDF has a drive."""
    return is_drive(_plugins(model))


def is_drive(plugins: Sequence[ElementTree.Element]) -> bool:
    """Return whether one of some plugins is a drive, whatever the values of its tags are."""
    return any(map(_row_of, plugins))


def _plugins(model: Model) -> List[ElementTree.Element]:
    return [plugin for tag in model.tags if not tag.link
            for plugin in tag.element.findall('plugin')]


def _of_plugins(plugins: Sequence[ElementTree.Element],
                step_s: float) -> Optional[DriveDescription]:
    """Return the first drive that plugins stand for, with their settings."""
    for plugin in plugins:
        row = _row_of(plugin)
        if row is not None:
            return row.with_settings(values_in(row.tags, '', None, plugin, step_s))
    return None


def _row_of(plugin: ElementTree.Element) -> Optional[DriveDescription]:
    return next((row for row in PLUGINS if is_of(plugin, row.tags)), None)
