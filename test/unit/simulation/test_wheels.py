"""The separation and diameter of the wheels of a URDF."""
import os
import re
from math import acos, atan2

import numpy as np
import pytest

from img_recog.model import BOX, Shape, Solid
from img_recog.simulation import wheels
from img_recog.simulation.simulation_settings import DriveSettings
from img_recog.simulation.wheels import Wheels
from img_recog_helpers import wheeled
from img_recog_helpers.parsed import given, lumped
from img_recog_helpers.robots import assemble, burger, burgers_drive, read

COLLISION = '<collision>\n      <geometry><cylinder radius="0.033" length="0.018"/></geometry>'
TAG = ('<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>'
       'wheel_left_joint</leftJoint><rightJoint>wheel_right_joint</rightJoint>{}</plugin></gazebo>'
       '</robot>')


def changed(*pairs, count=-1):
    """Return the burger with texts replaced, the first `count` times."""
    urdf = burger('')
    for old, new in pairs:
        assert old in urdf, old
        urdf = urdf.replace(old, new, count)
    return urdf


def shaped(shape, count=2, origin=''):
    """Return the burger with another collision shape of both wheels, or of the left one alone."""
    assert burger().count(COLLISION) == 2
    return changed((COLLISION, '<collision>{}<geometry>{}</geometry>'.format(origin, shape)),
                   count=count)


def seen_alone():
    """Return the burger whose wheels have no collision shape."""
    urdf, count = re.subn('(?s)(<link name="wheel_.*?)<collision>.*?</collision>', r'\1', burger())
    assert count == 2
    return urdf


def in_rows(*rows):
    """Return a robot with several wheels on a side, and the names of their joints by side."""
    return wheeled.robot(rows=rows, separation=0.5, radius=0.08), {
        '{}_joint'.format(side): ', '.join('{}_{}_joint'.format(side, row)
                                           for row in range(len(rows)))
        for side in ('left', 'right')}


def turned_axis(robot):
    """Return a robot of which the axis of the second wheel on the left is turned."""
    urdf, joints = robot
    head, tail = urdf.split('name="left_1_joint"')
    return head + 'name="left_1_joint"' + tail.replace('xyz="0 0 1"', 'xyz="0 0 -1"', 1), joints


def swapped(robot):
    urdf, joints = robot
    return urdf, {'left_joint': joints['right_joint'], 'right_joint': joints['left_joint']}


CYLINDER, OUTWARD = '<cylinder radius="{}" length="0.018"/>', '<origin xyz="0 0 0.01"/>'
LEFT, RIGHT = 'xyz="0 0.08 0.023"', 'xyz="0 -0.080 0.023"'
WIDE = changed((LEFT, 'xyz="0 0.144 0.023"'), (RIGHT, 'xyz="0 -0.144 0.023"'))
ARM = ('<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" '
       'iyz="0" izz="1"/></inertial></link><joint name="{0}_joint" type="revolute">'
       '<parent link="{1}"/><child link="{0}"/><origin xyz="{2}" rpy="0 0 {3}"/>'
       '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')
# the left wheel hangs on an arm, 0.1 m further out, and that on another one, 0.2 m
ON_ARMS = changed(
    ('<parent link="base_link"/>\n    <child link="wheel_left_link"/>',
     '<parent link="arm"/>\n    <child link="wheel_left_link"/>'),
    ('</robot>', ARM.format('post', 'base_link', '0 0.2 0', '1.5707963267948966')
     + ARM.format('arm', 'post', '0.1 0 0', '-1.5707963267948966') + '</robot>'))
# URDFs, settings of the drive, and what is measured
CASES = {
    'the burger': (burger(), {}, Wheels(0.16, 0.066)),
    'wheels that are farther apart': (WIDE, {}, Wheels(0.288, 0.066)),
    'larger wheels': (shaped(CYLINDER.format(0.05)), {}, Wheels(0.16, 0.1)),
    'balls': (shaped('<sphere radius="0.04"/>'), {}, Wheels(0.16, 0.08)),
    'tyres beside the joints, both to the left': (
        shaped(CYLINDER.format(0.033), origin=OUTWARD), {}, Wheels(0.16, 0.066)),
    'one tyre beside its joint': (
        shaped(CYLINDER.format(0.033), 1, OUTWARD), {}, Wheels(0.17, 0.066)),
    'boxes': (shaped('<box size="1 1 1"/>'), {}, Wheels(0.16, None)),
    'wheels that differ': (shaped(CYLINDER.format(0.04), 1), {}, Wheels(0.16, None)),
    'wheels that are only seen': (seen_alone(), {}, Wheels(0.16, 0.066)),
    'joints below other joints': (ON_ARMS, {}, Wheels(0.46, 0.066)),
    'no left joint': (burger(), {'left_joint': 'none'}, Wheels()),
    'no right joint': (burger(), {'right_joint': 'none'}, Wheels()),
    'one joint for both': (burger(), {'left_joint': 'wheel_right_joint'}, Wheels()),
    'a base that moves itself': (burger(), {'drive': 'planar'}, Wheels()),
    'two wheels on a side': (*in_rows(0.15, -0.15), Wheels(0.5, 0.16)),
    'three wheels on a side': (*in_rows(0.2, 0.0, -0.2), Wheels(0.5, 0.16)),
    'left joints on the right': (*swapped(in_rows(0.15, -0.15)),
                                 Wheels(0.5, 0.16, swapped=True)),
    'the axis of the first left wheel counts': (*turned_axis(in_rows(0.15, -0.15)),
                                                Wheels(0.5, 0.16)),
    'lengths to the micrometer': (
        changed((LEFT, 'xyz="0 0.0834564 0.023"'), (COLLISION, COLLISION.replace(
            '0.033', '0.03333337'))), {}, Wheels(0.163456, 0.066667)),
    'wheels in the same place': (changed((LEFT, 'xyz="0.1 -0.08 0.023"')), {},
                                 Wheels(None, 0.066))}


@pytest.mark.parametrize('urdf, settings, wanted', list(CASES.values()), ids=list(CASES))
def test_what_is_measured(urdf, settings, wanted):
    assert wheels.measure(lumped(urdf), burgers_drive(**settings)) == wanted


def drive_of(urdf, tags=''):
    return read(urdf.replace('</robot>', TAG.format(tags))).settings.drive


def test_what_is_measured_counts_where_no_tag_says_it():
    assert burgers_drive() == DriveSettings(
        left_joint='wheel_left_joint', right_joint='wheel_right_joint', wheel_separation=0.16,
        wheel_diameter=0.066, wheel_torque=10.0, wheel_acceleration=1.0, drive_period_s=0.01)
    assert drive_of(WIDE).wheel_separation == 0.288
    assert drive_of(WIDE, '<wheelSeparation>0.287</wheelSeparation>').wheel_separation == 0.287


@pytest.mark.parametrize('settings, lines', [
    ({}, ()), ({'wheel_separation': 0.165}, ()),
    ({'wheel_separation': 0.3}, (
        'robot_description: wheel_separation is 0.3 m, but in the URDF it is 0.16 m: the robot '
        'will move at another speed than commanded',)),
    ({'wheel_diameter': 0.06}, (
        'robot_description: wheel_diameter is 0.06 m, but in the URDF it is 0.066 m: the robot '
        'will move at another speed than commanded',))])
def test_a_contradiction_is_a_warning(settings, lines):
    assert assemble(drive=burgers_drive(**settings)).world.report.lines() == list(lines)


NOT_MEASURED = ('robot.urdf: the URDF does not state the diameter of the wheels, and it cannot be '
                'measured: 0.15 m is assumed; if that is wrong, set the parameter wheel_diameter')
PLAIN = '<mesh filename="wheel"/>'
DIFF_DRIVE = {'leftJoint': 'left_0_joint', 'rightJoint': 'right_0_joint'}


IS_0_16 = ('robot.urdf: wheel_diameter is 0.12 m, but in the URDF it is 0.16 m: the robot will '
           'move at another speed than commanded')
IN_MM = '<mesh filename="wheel" scale="0.001 0.001 0.001"/>'


# a mesh, the shape of the wheels and tags; the diameter, and what is said about the wheels
@pytest.mark.parametrize('mesh, shape, tags, diameter, lines', [
    (wheeled.wheel_mesh(0.08), PLAIN, {}, 0.16, []),
    (wheeled.wheel_mesh(80, width=50), IN_MM, {}, 0.16, []),
    # what is no wheel about the axis cannot be measured, and need not be if a diameter is given
    (wheeled.wheel_mesh(0.08, (0.05, 0.0)), PLAIN, {}, 0.15, [NOT_MEASURED]),
    (wheeled.wheel_mesh(0.08, (0.0, -0.3)), PLAIN, {}, 0.15, [NOT_MEASURED]),
    (wheeled.wheel_mesh(0.08, (0.3, 0.0)), PLAIN, {'wheelDiameter': '0.15'}, 0.15, []),
    (wheeled.wheel_mesh(0.08), PLAIN, {'wheelDiameter': '0.12'}, 0.12, [IS_0_16])])
def test_the_radius_of_a_mesh_is_measured_about_the_axis_of_its_joint(
        tmp_path, mesh, shape, tags, diameter, lines):
    path = tmp_path / 'wheel.obj'
    path.write_text(mesh)
    built = wheeled.assembled(wheeled.robot(
        wheeled.plugin('gazebo_ros_diff_drive', **DIFF_DRIVE, **tags), shape=shape),
        find_mesh=lambda uri: str(path))
    drive = built.robots[0].settings.drive
    assert (drive.wheel_diameter, drive.wheel_separation) == (diameter, 0.4)
    assert [line for line in built.world.report.lines() if 'wheel_' in line] == lines


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


def outline(path, axis, inside='', origin=''):
    link, = given(
        '<robot><link name="a"><collision>{}<geometry><mesh filename="{}" {}/></geometry>'
        '</collision></link></robot>'.format(origin, path, inside), str).links
    return wheels.mesh_outline(link.solids[0], np.array(axis, float))


@pytest.mark.parametrize('axis, origin', [
    ((0, 0, 1), '0.0 0.0 0.07" rpy="0 0 0'), ((0, 0, -1), '0.0 0.0 0.07" rpy="0 0 0'),
    ((1, 0, 0), '0.07 0 0" rpy="0 1.5707963267948966 0'),
    ((0, 0.6, 0.8), '0 0.042 0.056" rpy="-0.6435011087932844 0 0'),
    ((0.48, 0.6, 0.64), '0.0336 0.042 0.0448" rpy="0 {} {}'.format(acos(0.64), atan2(0.6, 0.48)))])
def test_the_outline_of_a_mesh_beside_the_origin(tmp_path, axis, origin):
    (tmp_path / 'wheel.obj').write_text(wheeled.wheel_mesh(0.08, width=0.05))
    found = outline(tmp_path / 'wheel.obj', axis, origin='<origin xyz="{}"/>'.format(origin))
    assert found.middle == pytest.approx(0.07 * np.abs(axis))
    assert (found.width, found.diameter) == pytest.approx((0.05, 0.16))


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
