"""The speed that each kind of drive has against the speed that is asked of it."""
import math

import pybullet
import pytest
import trimesh

from img_recog.conversions.sensor_table import SENSORS
from img_recog.formats import world_file
from img_recog.settings import from_mapping
from img_recog.simulation import assembly
from img_recog.simulation.physics.drive import DifferentialDrive
from img_recog.simulation.configured_model import from_urdf
from img_recog.simulation.simulation_settings import DriveSettings, PhysicsSettings
from img_recog_helpers.refusals import refusal
from img_recog_helpers.wheeled import (TURN_SHARE, assembled, controllers, plugin, robot,
                                       velocity, wheel_mesh)

DIFFERENTIAL = plugin('gazebo_ros_diff_drive', leftJoint='left_0_joint',
                      rightJoint='right_0_joint')
SKID = plugin('gazebo_ros_skid_steer_drive', leftFrontJoint='left_0_joint', torque=20,
              leftRearJoint='left_1_joint', rightFrontJoint='right_0_joint',
              rightRearJoint='right_1_joint', broadcastTF='true', robotBaseFrame='base_link')
PLANAR = plugin('gazebo_ros_planar_move', robotBaseFrame='base_link')
CONTROL = plugin('gazebo_ros_control')
FOUR = (0.15, -0.15)
COMMANDS = ((0.4, 0.0), (0.0, -0.8), (-0.3, 0.5))


def odometry(simulator, steps=2000):
    return [each.value for each in simulator.advance(steps) if each.sensor == 'odometry']


@pytest.mark.parametrize('urdf, given', [
    (robot(DIFFERENTIAL), {}), (robot(CONTROL), controllers()),
    # the names of an old package: in its <legacyMode>, left is right
    (robot(plugin('gazebo_ros_diff_drive', leftJoint='right_0_joint',
                  rightJoint='left_0_joint')), {}),
    (robot(PLANAR, rows=FOUR), {})])
@pytest.mark.parametrize('forward, turn', COMMANDS)
def test_what_does_not_slip_drives_as_asked(urdf, given, forward, turn):
    simulator = assembled(urdf, given)
    got = velocity(simulator, forward, turn)
    assert got[0] == pytest.approx(forward, rel=0.02, abs=0.004)
    assert got[1] == pytest.approx(0.0, abs=0.004)
    share = 1.0 if urdf.count(PLANAR) else TURN_SHARE
    assert got[2] == pytest.approx(share * turn, rel=0.02, abs=0.004)
    # 2 wheels and 2 casters or 4 wheels stand on the floor, and stay there
    assert simulator.robots[0].body.motion().position[2] == pytest.approx(0.0, abs=0.002)


def test_a_planar_base_moves_sideways_and_on_an_arc():
    simulator = assembled(robot(PLANAR))
    assert velocity(simulator, 0.0, 0.0, 0.3) == pytest.approx((0.0, 0.3, 0.0), abs=0.004)
    assert velocity(simulator, 0.2, 0.5, -0.3) == pytest.approx((0.2, -0.3, 0.5), rel=0.02)
    # its odometry is the truth
    motion = odometry(simulator, 50)[-1]
    assert motion.linear == pytest.approx([0.2, -0.3, 0.0], abs=0.005)
    assert motion.angular == pytest.approx([0, 0, 0.5], abs=0.005)
    true = simulator.robots[0].body.motion()
    assert motion.position == pytest.approx(true.position, abs=0.005)


def test_the_wheels_of_a_planar_base_stop():
    simulator = assembled(robot(PLANAR))
    body = simulator.robots[0].body
    for joint in body.joints.values():
        pybullet.resetJointState(body.body_id, joint, 0.0, 3.0,
                                 physicsClientId=body.physics_client_id)
    simulator.advance(500)
    assert body.joint_states().velocities == pytest.approx([0.0] * len(body.joints), abs=0.01)


def test_a_wall_stops_a_planar_base_and_it_falls_off_an_edge():
    simulator = assembled(robot(PLANAR))
    driven = simulator.robots[0]
    simulator.world.step(100)
    driven.body.place(driven.body.pose()._replace(position=(0, 0, 1.0)))
    driven.command(0.5, 0.0)
    simulator.advance(1000)
    # 0.45 s of free fall, in which it keeps its speed
    assert driven.body.motion().position[2] == pytest.approx(0.0, abs=0.01)
    assert driven.body.motion().position[0] == pytest.approx(0.5, rel=0.03)


@pytest.mark.parametrize('urdf, given, rows', [
    (robot(SKID, rows=FOUR), {}, FOUR),
    (robot(CONTROL, rows=(0.2, 0.0, -0.2)), controllers(3), (0.2, 0.0, -0.2))])
def test_a_skid_steered_robot_drives_straight_as_asked_and_slips_when_it_turns(urdf, given, rows):
    simulator = assembled(urdf, given)
    assert velocity(simulator, 0.4)[0] == pytest.approx(0.4, rel=0.02)
    assert velocity(simulator, -0.3)[0] == pytest.approx(-0.3, rel=0.02)
    for turn in (1.0, -1.0):
        assert 0.5 < velocity(simulator, 0.0, turn)[2] / turn < 0.9


def test_the_odometry_of_a_skid_steered_robot_is_that_of_its_plugin():
    # libgazebo_ros_skid_steer_drive publishes the truth, diff_drive_controller what wheels turn
    simulator = assembled(robot(SKID, rows=FOUR))
    velocity(simulator, 0.0, 1.0)
    true = simulator.robots[0].body.motion().angular[2]
    assert odometry(simulator, 100)[-1].angular[2] == pytest.approx(true, rel=0.08)
    simulator = assembled(robot(CONTROL, rows=FOUR), controllers(2))
    velocity(simulator, 0.0, 1.0)
    assert odometry(simulator, 100)[-1].angular[2] == pytest.approx(1.0, rel=0.02)
    assert simulator.robots[0].body.motion().angular[2] < 0.9


def test_limits_are_those_of_the_controller():
    given = controllers(linear={'x': {
        'has_velocity_limits': True, 'max_velocity': 0.4, 'min_velocity': -0.1,
        'has_acceleration_limits': True, 'max_acceleration': 0.2, 'min_acceleration': -0.8}})
    simulator = assembled(robot(CONTROL), given)
    driven, speeds = simulator.robots[0], []
    for command, steps in ((9.0, 1000), (9.0, 2000), (-9.0, 400), (-9.0, 1000)):
        for _ in range(steps // 100):
            driven.command(command, 0.0)
            simulator.advance(100)
        speeds.append(driven.body.motion().linear[0])
    assert speeds == pytest.approx([0.2, 0.4, 0.08, -0.1], abs=0.01)


@pytest.mark.parametrize('radius', [0.1, 0.04])
def test_wheels_that_are_meshes_drive_as_asked(radius, tmp_path):
    path = str(tmp_path / 'wheel.obj')
    with open(path, 'w') as file:
        file.write(wheel_mesh(radius))
    urdf = robot(DIFFERENTIAL, radius=radius, shape='<mesh filename="wheel"/>')
    built = assembled(urdf, find_mesh=lambda uri: path)
    assert not [line for line in built.world.report.lines() if 'wheel_' in line]
    assert built.robots[0].settings.drive.wheel_diameter == pytest.approx(2 * radius)
    assert velocity(built, 0.2)[0] == pytest.approx(0.2, rel=0.02)
    assert velocity(built, 0.0, 0.5)[2] == pytest.approx(TURN_SHARE * 0.5, rel=0.02)
    assert built.robots[0].body.motion().position[2] == pytest.approx(0, abs=0.002)


@pytest.mark.parametrize('suffix', ['.obj', '.stl'])
def test_casters_that_are_meshes_leave_the_wheels_on_the_floor(suffix, tmp_path):
    # with the margin of PyBullet's convex hulls, they would hold the wheels 1 mm above it
    path = str(tmp_path / 'caster.obj')
    with open(path, 'w') as file:
        file.write(wheel_mesh(20.0, (100.0, 50.0), width=40.0))
    if suffix == '.stl':
        path = str(tmp_path / 'caster.stl')
        trimesh.load(str(tmp_path / 'caster.obj')).export(path)
    mesh = ('<origin xyz="-0.1 -0.05 0"/><geometry><mesh filename="caster" '
            'scale="0.001 0.001 0.001"/></geometry>')
    urdf = robot(DIFFERENTIAL).replace('<geometry><sphere radius="0.02"/></geometry>', mesh)
    assert urdf.count('scale') == 2
    simulator = assembled(urdf, find_mesh=lambda uri: path)
    assert velocity(simulator, 0.2)[0] == pytest.approx(0.2, rel=0.02)
    assert velocity(simulator, 0.0, 0.5)[2] == pytest.approx(TURN_SHARE * 0.5, rel=0.02)
    assert simulator.robots[0].body.motion().position[2] == pytest.approx(0, abs=2e-4)


@pytest.mark.parametrize('left, right, wanted', [
    ('a', 'a', 'the same as right_joint'), ('a, b', 'a', 'each once'), ('a, a', 'b', 'each once'),
    (',', 'b', 'each once'), ('a', ',', 'each once')])
def test_refuses_joints_that_are_not_those_of_two_sides(left, right, wanted):
    assert wanted in refusal(DifferentialDrive, DriveSettings(left_joint=left, right_joint=right))


def given(**parameters):
    """Return the simulator of a robot without a plugin, but with parameters."""
    spec = from_urdf(robot(), 0.001, lambda uri: None, 'robot', SENSORS,
                     read=lambda kind, values: from_mapping(kind, {**values, **parameters}))
    return assembly.build(PhysicsSettings(world='empty'), world_file.read('empty', {}),
                          [spec])


@pytest.mark.parametrize('parameters, speed', [
    ({}, 0.0), ({'left_joint': 'left_0_joint', 'right_joint': 'right_0_joint'}, 0.4),
    ({'drive': 'planar'}, 0.4), ({'wheel_separation': 0.4}, 0.0)])
def test_without_a_plugin_a_robot_drives_by_parameters_or_stands(parameters, speed):
    simulator = given(**parameters)
    assert velocity(simulator, 0.4) == pytest.approx((speed, 0.0, 0.0), abs=0.004)
    measured = [motion.linear[0] for motion in odometry(simulator, 100)[-1:]]
    assert measured == ([pytest.approx(speed, abs=0.01)] if speed else [])
    drive = simulator.robots[0].settings.drive
    if drive.left_joints:       # what nothing gives is measured, or that of the plugin
        assert (drive.wheel_separation, drive.wheel_diameter, drive.wheel_torque,
                drive.wheel_acceleration) == (0.4, 0.2, 5.0, 0.0)


@pytest.mark.parametrize('command', [(float('nan'), 0.0, 0.0), (0.0, float('inf'), 0.0),
                                     (0.0, 0.0, float('-inf'))])
def test_a_command_that_is_not_finite_is_refused(command):
    driven, = assembled(robot(DIFFERENTIAL, FOUR)).robots
    assert refusal(driven.command, *command).startswith('command: got [')


@pytest.mark.parametrize('tags', [DIFFERENTIAL, PLANAR])
def test_an_endless_command_brings_no_nan(tags):
    simulator = assembled(robot(tags, FOUR))
    for _ in range(30):
        simulator.robots[0].command(1e308, -1e308, 1e308)
        simulator.advance(10)
    assert all(map(math.isfinite, simulator.robots[0].body.pose().position))
