"""Bodies: their poses, joints and velocities, in the frame of their root link."""
import math

import numpy as np
import pytest

from img_recog import rotations
from img_recog.simulation.physics.body import BodyPose, motion_of_frame
from img_recog_helpers import robots

TURNED = (0.0, 0.0, math.sin(0.4), math.cos(0.4))


@pytest.fixture
def robot():
    return robots.assemble().robots[0].body


def test_a_body_is_placed_with_its_joints_at_rest(robot):
    robot.set_velocity((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    robot.place(BodyPose((1.0, 2.0, 0.5), TURNED, [0.25, -0.5]))
    pose = robot.pose()
    assert pose.position == pytest.approx((1.0, 2.0, 0.5), abs=1e-6)
    assert pose.orientation == pytest.approx(TURNED, abs=1e-6) and pose.joints == [0.25, -0.5]
    assert [value[1] for value in robot.joint_values()] == [0.0, 0.0]
    motion = robot.motion()
    assert np.array([motion.linear, motion.angular]) == pytest.approx(np.zeros((2, 3)), abs=1e-6)
    assert motion.position == pytest.approx([1.0, 2.0, 0.5]) and motion.yaw == pytest.approx(0.8)
    robot.reset()
    assert robot.pose().joints == [0.0, 0.0]
    assert robot.pose().position == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_velocity_is_that_of_the_root_link(robot):
    robot.place(BodyPose((1.0, 2.0, 0.5), TURNED, [0.0, 0.0]))
    robot.set_velocity((0.3, -0.2, 0.1), (0.5, 0.6, -0.7))
    motion = robot.motion()
    turn = rotations.matrix(motion.orientation)
    assert turn @ motion.linear == pytest.approx([0.3, -0.2, 0.1], abs=1e-6)
    assert turn @ motion.angular == pytest.approx([0.5, 0.6, -0.7], abs=1e-6)


def test_velocity_of_a_wheel_of_a_turning_robot(robot):
    robot.place(BodyPose((1.0, 2.0, 0.5), (0.0, 0.0, 0.0, 1.0), [0.0, 0.0]))
    robot.set_velocity((0.3, 0.0, 0.0), (0.0, 0.0, 2.0))
    for frame, y in (('wheel_left_link', 0.08), ('wheel_right_link', -0.08)):
        motion = robot.motion(frame)
        turn = rotations.matrix(motion.orientation)
        assert turn @ motion.linear == pytest.approx([0.3 - 2.0 * y, 0.0, 0.0], abs=1e-6)


def test_frames_are_in_their_places_if_the_mass_of_the_root_is_not_in_its_origin():
    root = '<link name="base_footprint">'
    inertial = ('<inertial><origin xyz="0.1 0.2 0.05"/><mass value="1"/><inertia ixx="0.01" '
                'ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>')
    text = robots.burger().replace(root.replace('>', '/>'), root + inertial + '</link>')
    assert inertial in text
    robot = robots.assemble(urdf=text).robots[0].body
    for frame, position in (('base_footprint', (1.0, 2.0, 0.5)), ('base_link', (1.0, 2.0, 0.51)),
                            ('wheel_left_link', (1.0, 2.08, 0.533))):
        robot.place(BodyPose((1.0, 2.0, 0.5), (0.0, 0.0, 0.0, 1.0), [0.0, 0.0]))
        assert robot.motion(frame).position == pytest.approx(position, abs=1e-6), frame


def test_links_and_joints(robot):
    # wheels, each with a tread at its lower edge, and a caster
    assert list(robot.links) == [-1, 0, 1, 2, 3, 4] and robot.fixed is False
    assert robot.joints == {'wheel_left_joint': 0, 'wheel_right_joint': 2}
    assert robot.name == 'turtlebot3_burger'


def test_a_point_of_a_turning_part_moves_across_its_arm():
    # 2 m along x from a point that moves along y; turning about z and x
    motion = motion_of_frame(((3.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)), (1.0, 1.0, 0.0),
                             (0.0, 0.5, 0.0), (0.0, 0.0, 1.5))
    assert list(motion.linear) == [0.0, 3.5, 0.0] and list(motion.angular) == [0.0, 0.0, 1.5]
    motion = motion_of_frame(((1.0, 4.0, 5.0), (0.0, 0.0, 0.0, 1.0)), (1.0, 1.0, 1.0),
                             (0.0, 0.0, 0.0), (2.0, 3.0, 5.0))
    assert list(motion.linear) == list(np.cross((2.0, 3.0, 5.0), (0.0, 3.0, 4.0)))
    motion = motion_of_frame(((4.0, 1.0, 6.0), (0.0, 0.0, 0.0, 1.0)), (1.0, 2.0, 1.0),
                             (1.0, 2.0, 3.0), (7.0, 11.0, 13.0))
    assert list(motion.linear) == list(
        np.array((1.0, 2.0, 3.0)) + np.cross((7.0, 11.0, 13.0), (3.0, -1.0, 5.0)))
