"""Simulators as node, replay and tests build them: what they are made of, warnings, refusals."""

import pytest

from img_recog.conversions.sensor_table import SENSORS
from img_recog.report import lines_of
from img_recog.simulation.configured_model import from_urdf
from img_recog.simulation.sensors.odometry import OdometrySettings
from img_recog.simulation.simulation_settings import RobotSettings
from img_recog_helpers import wheeled
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, build, burger, burgers_drive, read
from img_recog_helpers.sdf import BUILT_IN, CRATE, sdf

TAGS = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint>
  <wheelSeparation>0.3</wheelSeparation><updateRate>50</updateRate></plugin></gazebo>
  <gazebo><plugin name="lamp" filename="liblamp.so"/></gazebo></robot>'''
UNIT = ('<gazebo><plugin name="i" filename="libgazebo_ros_imu.so"><bodyName>torso</bodyName>'
        '</plugin></gazebo>')
MESH = ('<link name="cover"><visual><geometry><mesh filename="package://lost/x.stl"/></geometry>'
        '</visual></link><joint name="cover_joint" type="fixed"><parent link="base_link"/>'
        '<child link="cover"/></joint></robot>')


def test_robot_with_its_tags_and_warnings():
    robot = read(burger('').replace('</robot>', TAGS).replace('</robot>', MESH))
    assert (robot.source, robot.model.name) == ('robot.urdf', 'turtlebot3_burger')
    assert robot.tag_values == {'left_joint': 'wheel_left_joint',
                                'right_joint': 'wheel_right_joint',
                                'wheel_separation': 0.3, 'odometry_period_s': pytest.approx(0.02),
                                'joint_states_period_s': pytest.approx(0.02),
                                'drive_period_s': pytest.approx(0.02)}
    mesh, tag = lines_of(robot.findings)
    assert mesh.startswith('robot.urdf: loaded without: mesh ') and 'package://lost/x.stl' in mesh
    assert tag.startswith('robot.urdf: ') and tag.endswith('plugin liblamp.so')
    assert lines_of(read(burger()).findings) == []


def test_tags_of_links_that_are_not_there_are_not_used():
    sensor = ('<gazebo reference="{0}"><sensor name="{0}" type="camera"><plugin '
              'filename="libgazebo_ros_camera.so"/></sensor></gazebo>')
    loose = ('<link name="loose"/><joint name="loose_joint" type="continuous"><child '
             'link="loose"/><parent link="base_link"/></joint><gazebo reference="loose_joint"/>')
    tags = ''.join(sensor.format(name) for name in ('camera_link', 'lost', 'loose', 'lost'))
    robot = read(burger('').replace('</robot>', loose + tags + '</robot>'))
    assert [camera.camera_frame for camera in robot.cameras] == ['camera_link']
    assert lines_of(robot.findings) == [
        'robot.urdf: not simulated: link loose with joint loose_joint and all that is joined to '
        'it; it can move but has no mass, so it is left out as in Gazebo; give it an <inertial>',
        'robot.urdf: not used: the <gazebo> tag, as there is no such link, of lost, loose']


@pytest.mark.parametrize('odometry, origin', [('world', (0.0, 0.0, 0.0)),
                                              ('encoder', (1.0, 2.0, 0.5))])
def test_where_the_odometry_is_zero(odometry, origin):
    sim = assemble(x=1.0, y=2.0, yaw=0.5,
                   odometry=OdometrySettings(odometry_source=odometry))
    sim.robots[0].move_to(3.0, 3.0, 0.0)
    assert sim.robots[0].odometry_origin == origin


def test_default_settings_are_those_of_tags_and_else_the_defaults():
    assert read(burger('')).settings == RobotSettings(sensors={})
    settings = read(burger('').replace('</robot>', TAGS)).settings
    assert settings.drive == burgers_drive(wheel_separation=0.3, wheel_torque=5.0,
                                           wheel_acceleration=0.0, drive_period_s=0.02)
    assert settings.sensors['odometry'].odometry_period_s == pytest.approx(0.02)
    assert set(settings.sensors) == {'odometry', 'joint_states'}


def test_simulator_and_scene_of_the_world_and_the_robot():
    built = assemble('turtlebot3_world', x=-2.0, y=-0.5)
    robot, = built.robots
    assert robot.body.motion().position == pytest.approx([-2.0, -0.5, 0.0], abs=1e-6)
    assert [body.name for body in built.world.scenery] == ['turtlebot3_world']
    assert [tree.name for tree in built.world.trees] == [
        'turtlebot3_world', 'turtlebot3_burger']
    assert built.world.file.name == 'turtlebot3_world'
    assert built.world.report.lines() == []


def test_sensors_without_a_link_are_warned_of_unless_unused():
    urdf, unused = burger(UNIT), ('imu', 'scan')
    assert assemble(urdf=urdf).world.report.lines() == [
        'robot_description: not simulated: sensor imu: no link torso']
    assert assemble(urdf=urdf, unused_sensors=unused).world.report.lines() == []
    simulator = assemble(urdf=urdf)
    robot, = simulator.robots
    assert robot.mounted.missing == {'imu': 'torso'} and simulator.advance(400) == []
    robot.mounted.set_enabled('imu', True)
    # those that have their links are disabled
    readings = assemble(unused_sensors=unused).advance(400)
    assert {reading.sensor for reading in readings} == {'odometry', 'joint_states'}


@pytest.mark.parametrize('option_name, names', [
    (str, 'x_pos, y_pos, z_pos'), (str.upper, 'X_POS, Y_POS, Z_POS')])
def test_overlap_at_the_start_names_the_options(option_name, names):
    warning, = assemble('turtlebot3_world', 0.0, 0.1, option_name=option_name).world.report.lines()
    assert warning.startswith('turtlebot3_burger in turtlebot3_world: ')
    assert warning.endswith('set ' + names)


def test_warnings_of_the_world_file_come_first():
    world = sdf('<include><uri>model://table</uri></include>')
    warnings = assemble(world, urdf=burger(UNIT), allow_partial=True).world.report.lines()
    assert len(warnings) == 3 and 'model://table' in warnings[0] and 'imu' in warnings[1]


def test_warns_of_what_was_lifted_out_of_the_floor():
    assert assemble(sdf(BUILT_IN, CRATE.format('2 0 0 0 0 0'))).world.report.lines() == [
        'world hall: in the floor at the start, and lifted onto it: crate by 0.100 m']


@pytest.mark.parametrize('value, words', [
    ('wide', "<wheelSeparation> of plugin drive: got 'wide'"),
    ('-1', 'wheel_separation: got -1.0, allowed is'),
    ('0.3</robot>', 'not XML')])
def test_text_that_cannot_be_used_is_refused_with_its_source(value, words):
    text = burger('').replace('</robot>', TAGS.replace('0.3', value))
    assert refusal(read, text).startswith(
        'cannot use the robot in robot.urdf: ' + words)


SET_JOINT = ('set left_joint to the joint of a wheel; one that moves nothing with an <inertial> '
             'is left out')


@pytest.mark.parametrize('urdf, joint, words', [
    (burger(), 'axle', 'the robot has no movable joint axle (movable joints: wheel_left_joint, '
     'wheel_right_joint); ' + SET_JOINT),
    (burger().replace('value="0.02849894"', 'value="0"', 1), 'wheel_left_joint',
     'the robot has no movable joint wheel_left_joint (movable joints: wheel_right_joint); '
     + SET_JOINT)])
def test_robot_that_does_not_fit_its_settings_is_refused_with_its_source(urdf, joint, words):
    assert refusal(assemble, urdf=urdf, drive=burgers_drive(left_joint=joint)) == (
        'cannot use the robot in robot_description: ' + words)


def test_the_controllers_of_a_robot_are_asked_for_once():
    asked = []

    def controllers(namespace):
        asked.append(namespace)
        return wheeled.controllers()
    spec = from_urdf(wheeled.robot(wheeled.plugin('gazebo_ros_control')), 0.001, lambda uri: None,
                     'robot', SENSORS, controllers)
    assert (spec.settings.drive.left_joint, asked) == ('left_0_joint', [''])


def test_robots_in_one_place_are_one_line():
    urdf = burger('')
    robots = [read(urdf.replace('turtlebot3_burger', name)) for name in ('one', 'two')]
    warnings = build('empty', robots).world.report.lines()
    assert [line for line in warnings if 'overlap' in line] == [
        'one in two: they overlap at the start, and the physics will throw them apart; set '
        'x_pos, y_pos, z_pos']
