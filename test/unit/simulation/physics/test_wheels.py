"""The separation and diameter of the wheels of a URDF."""
import os
import xml.etree.ElementTree as ElementTree
from math import acos, atan2

import numpy as np
import pytest

from img_recog.model import BOX, Shape, Solid
from img_recog.simulation.physics import wheels
from img_recog.simulation.physics.wheels import Wheels
from img_recog.simulation.simulation_settings import DriveSettings
from img_recog_helpers import wheeled
from img_recog_helpers.parsed import given, lumped
from img_recog_helpers.robots import assemble, burger, burgers_drive, read

COLLISION = '<collision>\n      <geometry><cylinder radius="0.033" length="0.018"/></geometry>'
TAG = ('<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>'
       'wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint>{}</plugin></gazebo>'
       '</robot>')


def changed(*pairs):
    urdf = burger('')
    for old, new in pairs:
        assert old in urdf, old
        urdf = urdf.replace(old, new)
    return urdf


WIDE = changed(('xyz="0 0.08 0.023"', 'xyz="0 0.144 0.023"'),
               ('xyz="0 -0.080 0.023"', 'xyz="0 -0.144 0.023"'))


def measure(urdf, **settings):
    return wheels.measure(lumped(urdf), burgers_drive(**settings))


def drive_of(urdf, tags=''):
    return read(urdf.replace('</robot>', TAG.format(tags))).settings.drive


def test_the_burgers_are_in_its_tags():
    assert measure(burger()) == Wheels(0.16, 0.066)
    assert burgers_drive() == DriveSettings(
        left_joint='wheel_left_joint', right_joint='wheel_right_joint', wheel_separation=0.16,
        wheel_diameter=0.066, wheel_torque=10.0, wheel_acceleration=1.0, drive_period_s=0.01)


def test_wheels_that_are_farther_apart():
    assert measure(WIDE) == Wheels(0.288, 0.066)
    assert drive_of(WIDE).wheel_separation == 0.288


def test_a_tag_counts_more():
    assert drive_of(WIDE, '<wheelSeparation>0.287</wheelSeparation>').wheel_separation == 0.287


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


ARM = ('<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" '
       'iyz="0" izz="1"/></inertial></link><joint name="{0}_joint" type="revolute">'
       '<parent link="{1}"/><child link="{0}"/><origin xyz="{2}" rpy="0 0 {3}"/>'
       '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')


def test_joints_below_other_joints():
    # the left wheel hangs on an arm, 0.1 m further out, and that on another one, 0.2 m
    urdf = changed(
        ('<parent link="base_link"/>\n    <child link="wheel_left_link"/>',
         '<parent link="arm"/>\n    <child link="wheel_left_link"/>'),
        ('</robot>', ARM.format('post', 'base_link', '0 0.2 0', '1.5707963267948966')
         + ARM.format('arm', 'post', '0.1 0 0', '-1.5707963267948966') + '</robot>'))
    assert measure(urdf) == Wheels(0.46, 0.066)


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
    assert assemble(drive=burgers_drive(**settings)).warnings == lines


NOT_MEASURED = ('robot.urdf: the URDF does not state the diameter of the wheels, and it cannot be '
                'measured: 0.15 m is assumed; if that is wrong, set the parameter wheel_diameter')
DIFF_DRIVE = {'leftJoint': 'left_0_joint', 'rightJoint': 'right_0_joint'}


def with_mesh(tmp_path, text, shape='<mesh filename="wheel"/>', **tags):
    """Return the diameter, the separation and the lines about the wheels of a robot."""
    path = str(tmp_path / 'wheel.obj')
    with open(path, 'w') as file:
        file.write(text)
    built = wheeled.assembled(wheeled.robot(
        wheeled.plugin('gazebo_ros_diff_drive', **DIFF_DRIVE, **tags), shape=shape),
        find_mesh=lambda uri: path)
    drive = built.simulator.vehicles[0].settings.drive
    return drive.wheel_diameter, drive.wheel_separation, [
        line for line in built.warnings if 'wheel_' in line]


def test_the_radius_of_a_mesh_is_measured_about_the_axis_of_its_joint(tmp_path):
    assert with_mesh(tmp_path, wheeled.wheel_mesh(0.08)) == (0.16, 0.4, [])
    assert with_mesh(tmp_path, wheeled.wheel_mesh(80, width=50), shape=(
        '<mesh filename="wheel" scale="0.001 0.001 0.001"/>')) == (0.16, 0.4, [])


@pytest.mark.parametrize('middle', [(0.05, 0.0), (0.0, -0.3)])
def test_what_is_no_wheel_about_the_axis_cannot_be_measured(tmp_path, middle):
    assert with_mesh(tmp_path, wheeled.wheel_mesh(0.08, middle)) == (0.15, 0.4, [NOT_MEASURED])


def test_a_diameter_that_is_given_needs_no_measurement(tmp_path):
    given = {'wheelDiameter': '0.15'}
    assert with_mesh(tmp_path, wheeled.wheel_mesh(0.08, (0.3, 0)), **given) == (0.15, 0.4, [])
    diameter, _, lines = with_mesh(tmp_path, wheeled.wheel_mesh(0.08), wheelDiameter='0.12')
    assert (diameter, len(lines)) == (0.12, 1)
    assert 'wheel_diameter is 0.12 m, but in the URDF it is 0.16 m' in lines[0]


def test_a_wheel_without_a_collision_shape_is_measured_at_what_is_seen():
    urdf = burger().replace(COLLISION, COLLISION.replace('0.033', '0.04'))
    for side in ('left', 'right'):
        assert measure(without_collision(urdf, 'wheel_{}_link'.format(side))).wheel_separation
    bare = without_collision(without_collision(urdf, 'wheel_left_link'), 'wheel_right_link')
    assert measure(bare) == Wheels(0.16, 0.066)


def without_collision(urdf, name):
    root = ElementTree.fromstring(urdf)
    link = next(each for each in root.findall('link') if each.get('name') == name)
    for shape in link.findall('collision'):
        link.remove(shape)
    return ElementTree.tostring(root, 'unicode')


@pytest.mark.parametrize('rows', [(0.15, -0.15), (0.2, 0.0, -0.2)])
def test_several_wheels_on_a_side(rows):
    names = {side: ', '.join('{}_{}_joint'.format(side, row) for row in range(len(rows)))
             for side in ('left', 'right')}
    robot = lumped(wheeled.robot(rows=rows, separation=0.5, radius=0.08))
    drive = burgers_drive(left_joint=names['left'], right_joint=names['right'])
    assert wheels.measure(robot, drive) == Wheels(0.5, 0.16)
    drive = burgers_drive(left_joint=names['right'], right_joint=names['left'])
    assert wheels.measure(robot, drive) == Wheels(0.5, 0.16, swapped=True)


def test_a_base_that_moves_itself_has_no_wheels():
    assert measure(burger(), drive='planar') == Wheels()


def test_a_wide_robot_turns_as_commanded():
    built = assemble(urdf=WIDE, drive=drive_of(WIDE))
    assert built.warnings == ()
    built.simulator.vehicles[0].command(0.0, 0.5)
    built.simulator.advance(2000)
    assert built.simulator.vehicles[0].robot.motion().angular[2] == pytest.approx(0.5, rel=0.03)


@pytest.mark.parametrize('measured, given, diameter, count', [
    (Wheels(0.16), (), 0.15, 1), (Wheels(0.16), ('wheel_diameter',), 0.15, 0),
    (Wheels(0.16), (), 0.07, 0), (Wheels(0.16), (), 0.06, 0), (Wheels(), (), 0.066, 0),
    (Wheels(0.16, 0.066), (), 0.066, 0), (Wheels(0.16, 0.06), (), 0.066, 1),
    (Wheels(0.2, 0.05), (), 0.066, 2), (Wheels(None, 0.0695), (), 0.066, 1),
    (Wheels(None, 0.0694), (), 0.066, 0), (Wheels(None, 0.0628), (), 0.066, 1),
    (Wheels(None, 0.0629), (), 0.066, 0)])
def test_what_is_worth_a_warning(measured, given, diameter, count):
    drive = burgers_drive(wheel_diameter=diameter)
    assert len(measured.warnings(drive, given)) == count


def test_values_are_those_that_are_known():
    assert Wheels(0.3).values() == {'wheel_separation': 0.3}
    assert Wheels(wheel_diameter=0.1).values() == {'wheel_diameter': 0.1}
    assert not Wheels().swapped


def test_lengths_are_to_the_micrometer():
    urdf = changed(('xyz="0 0.08 0.023"', 'xyz="0 0.0834564 0.023"'),
                   (COLLISION, COLLISION.replace('0.033', '0.03333337')))
    assert measure(urdf) == Wheels(0.163456, 0.066667)


def test_wheels_in_the_same_place_have_no_separation():
    urdf = changed(('xyz="0 0.08 0.023"', 'xyz="0.1 -0.08 0.023"'))
    assert measure(urdf) == Wheels(None, 0.066, False)


def test_the_axis_of_the_first_left_wheel_says_which_side_is_left():
    urdf = wheeled.robot(rows=(0.15, -0.15), separation=0.5)
    head, tail = urdf.split('name="left_1_joint"')
    urdf = head + 'name="left_1_joint"' + tail.replace('xyz="0 0 1"', 'xyz="0 0 -1"', 1)
    drive = burgers_drive(left_joint='left_0_joint, left_1_joint',
                          right_joint='right_0_joint, right_1_joint')
    assert wheels.measure(lumped(urdf), drive) == Wheels(0.5, 0.2, False)


@pytest.mark.parametrize('axis, wanted', [
    ('', (1, 0, 0)), ('<axis/>', (1, 0, 0)), ('<axis xyz="0 3 -4"/>', (0, 0.6, -0.8))])
def test_the_axis_of_a_joint(axis, wanted):
    joint, = given('<robot><link name="a"/><link name="b"/><joint name="j" type="continuous">'
                   '<parent link="a"/><child link="b"/>{}</joint></robot>'.format(axis)).joints
    assert wheels.axis_of(joint) == pytest.approx(wanted)


def outline(path, axis, inside='', origin=''):
    link, = given(
        '<robot><link name="a"><collision>{}<geometry><mesh filename="{}" {}/></geometry>'
        '</collision></link></robot>'.format(origin, path, inside), str).links
    return wheels.mesh_outline(link.solids[0], np.array(axis, float))


def test_the_outline_of_a_mesh_beside_the_origin(tmp_path):
    path = tmp_path / 'wheel.obj'
    path.write_text(wheeled.wheel_mesh(0.08, width=0.05))
    for axis, origin in (((0, 0, 1), '0.0 0.0 0.07" rpy="0 0 0'),
                         ((0, 0, -1), '0.0 0.0 0.07" rpy="0 0 0'),
                         ((1, 0, 0), '0.07 0 0" rpy="0 1.5707963267948966 0'),
                         ((0, 0.6, 0.8), '0 0.042 0.056" rpy="-0.6435011087932844 0 0'),
                         ((0.48, 0.6, 0.64),
                          '0.0336 0.042 0.0448" rpy="0 {} {}'.format(acos(0.64),
                                                                     atan2(0.6, 0.48)))):
        found = outline(path, axis, origin='<origin xyz="{}"/>'.format(origin))
        assert found.middle == pytest.approx(0.07 * np.abs(axis))
        assert found.width == pytest.approx(0.05) and found.diameter == pytest.approx(0.16)


def test_the_outline_of_a_mesh_with_a_scale_for_each_axis(tmp_path):
    path = tmp_path / 'wheel.obj'
    path.write_text(wheeled.wheel_mesh(0.08))
    assert outline(path, (0, 0, 1), 'scale="2 2 3"')[1:] == (pytest.approx(0.12), 0.32)
    assert outline(path, (0, 0, 1), 'scale="1 2 1"')[1:] == (pytest.approx(0.04), None)
    path.write_text(wheeled.wheel_mesh(0.1234564))          # the file has changed
    os.utime(str(path), (1, 1))
    assert outline(path, (0, 0, 1))[1:] == (pytest.approx(0.04), 0.246913)


@pytest.mark.parametrize('middle, is_round', [(0.004, True), (0.005, False)])
def test_how_far_from_the_axis_a_wheel_can_be(tmp_path, middle, is_round):
    path = tmp_path / 'wheel.obj'
    path.write_text(wheeled.wheel_mesh(0.08, (0.0, middle)))
    found = outline(path, (0, 0, 1))
    assert found.diameter == (2 * (0.08 + middle) if is_round else None)
    assert found.middle.tolist() == [0, 0, 0]


def test_a_shape_that_is_no_mesh_or_cannot_be_read_has_no_outline(tmp_path):
    assert outline(tmp_path / 'missing.obj', (0, 0, 1)) is None
    box = Solid(Shape(BOX, (1.0, 1.0, 1.0)))
    assert wheels.mesh_outline(box, np.array((0.0, 0.0, 1.0))) is None
