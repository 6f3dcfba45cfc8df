"""The separation and diameter of the wheels of a URDF."""
import pytest

from img_recog.simulation import assembly
from img_recog.simulation.descriptions import description, wheels
from img_recog.simulation.descriptions.wheels import Wheels
from img_recog.simulation.settings import DriveSettings
from img_recog_testing.robots import assemble, burger, read

COLLISION = '<collision>\n      <geometry><cylinder radius="0.033" length="0.018"/></geometry>'
TAG = ('<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"><wheelSeparation>{}'
       '</wheelSeparation></plugin></gazebo></robot>')


def changed(*pairs):
    urdf = burger()
    for old, new in pairs:
        assert old in urdf, old
        urdf = urdf.replace(old, new)
    return urdf


WIDE = changed(('xyz="0 0.08 0.023"', 'xyz="0 0.144 0.023"'),
               ('xyz="0 -0.080 0.023"', 'xyz="0 -0.144 0.023"'))


def measure(urdf, **settings):
    return wheels.measure(description.parse(urdf), DriveSettings(**settings))


def drive_of(urdf):
    return assembly.default_settings(read(urdf)).drive


def test_the_burgers_are_the_defaults():
    assert measure(burger()) == Wheels(0.16, 0.066)
    assert drive_of(burger()) == DriveSettings()


def test_wheels_that_are_farther_apart():
    assert measure(WIDE) == Wheels(0.288, 0.066)
    assert drive_of(WIDE).wheel_separation == 0.288


def test_a_tag_counts_more():
    assert drive_of(WIDE.replace('</robot>', TAG.format(0.287))).wheel_separation == 0.287


# the collision shape of both wheels, or of the left one alone
@pytest.mark.parametrize('shape, count, expected', [
    (COLLISION.replace('0.033', '0.05'), 2, Wheels(0.16, 0.1)),
    ('<collision>\n      <geometry><sphere radius="0.04"/></geometry>', 2, Wheels(0.16, 0.08)),
    # the tyres are outside of the joints, along their axes: both to the left
    (COLLISION.replace('<geometry>', '<origin xyz="0 0 0.01"/><geometry>'), 2,
     Wheels(0.16, 0.066)),
    (COLLISION.replace('<geometry>', '<origin xyz="0 0 0.01"/><geometry>'), 1,
     Wheels(0.17, 0.066)),
    ('<collision>\n      <geometry><box size="1 1 1"/></geometry>', 2, Wheels(0.16, None)),
    (COLLISION.replace('0.033', '0.04'), 1, Wheels(0.16, None))])
def test_the_shape_of_the_wheels(shape, count, expected):
    assert burger().count(COLLISION) == 2
    assert measure(burger().replace(COLLISION, shape, count)) == expected


def test_joints_below_other_joints():
    # the left wheel hangs on an arm that turns about z, 0.1 m further out
    urdf = changed(
        ('<parent link="base_link"/>\n    <child link="wheel_left_link"/>',
         '<parent link="arm"/>\n    <child link="wheel_left_link"/>'),
        ('</robot>', '<link name="arm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
         'ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>'
         '<joint name="arm_joint" type="revolute"><parent link="base_link"/><child link="arm"/>'
         '<origin xyz="0 0.1 0"/><axis xyz="0 0 1"/>'
         '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'))
    assert measure(urdf).wheel_separation == 0.26


@pytest.mark.parametrize('joints', [
    {'left_joint': 'none'}, {'right_joint': 'none'}, {'left_joint': 'wheel_right_joint'}])
def test_unknown_joints_have_nothing_to_measure(joints):
    assert measure(burger(), **joints) == Wheels()


@pytest.mark.parametrize('settings, lines', [
    ({}, ()), ({'wheel_separation': 0.165}, ()),
    ({'wheel_separation': 0.3}, (
        'robot_description: wheel_separation is 0.3 m, but in the URDF it is 0.16 m: the robot '
        'will move at another speed than commanded',)),
    ({'wheel_diameter': 0.06}, (
        'robot_description: wheel_diameter is 0.06 m, but in the URDF it is 0.066 m: the robot '
        'will move at another speed than commanded',))])
def test_a_contradiction_is_a_warning(settings, lines):
    assert assemble(drive=DriveSettings(**settings)).warnings == lines


def test_a_wide_robot_turns_as_commanded():
    built = assemble(urdf=WIDE, drive=drive_of(WIDE))
    assert built.warnings == ()
    built.simulator.vehicles[0].command(0.0, 0.5)
    built.simulator.advance(2000)
    assert built.simulator.vehicles[0].robot.motion().angular[2] == pytest.approx(0.5, rel=0.03)
