"""What is added to a robot for its wheels, to the digit."""
import math

import numpy as np
import pytest

from img_recog.model import CYLINDER, MESH
from img_recog.simulation.physics import tyres
from img_recog_testing.parsed import given, part
from img_recog_testing.wheeled import wheel_mesh

JOINTS = 'left', 'right'
UPRIGHT = -math.pi / 2
ROUND = '<cylinder radius="{}" length="{}"/>'
INERTIAL = ('<inertial><mass value="0.2"/><inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.02" '
            'iyz="0" izz="0.03"/></inertial>')
WHEEL = ('<link name="{0}_wheel">{1}<collision>{2}<geometry>{3}</geometry></collision></link>'
         '<joint name="{0}" type="continuous"><parent link="base"/><child link="{0}_wheel"/>'
         '<origin xyz="0.1 0.2 0.3" rpy="{4!r} 0 0"/><axis xyz="{5}"/></joint>')


def robot(left=UPRIGHT, right=UPRIGHT, shape=ROUND.format(0.1, 0.04), origin='',
          inertial=INERTIAL, axis='0 0 1'):
    """Return a URDF; left and right: how the joints are turned about x."""
    return '<robot name="r"><link name="base"/>{}</robot>'.format(''.join(
        WHEEL.format(name, inertial, origin, shape, roll, axis)
        for name, roll in (('left', left), ('right', right))))


def added(urdf, joints=JOINTS, slip_radius=0.0):
    return tyres.added(given(urdf, lambda uri: uri), joints, slip_radius)


def cylinders(urdf, joints=JOINTS, name='left_wheel'):
    """Return radius and length of the cylinders of a wheel that has its tyres."""
    return [solid.shape.size for solid in part(added(urdf, joints).links, name).solids
            if solid.shape.kind == CYLINDER]


@pytest.mark.parametrize('radius, inner', [(0.1, 0.0799), (0.05, 0.0299), (0.03, 0.015)])
def test_a_wheel_has_a_narrow_tread_and_the_rest_is_above_the_floor(radius, inner):
    found = cylinders(robot(shape=ROUND.format(radius, 0.04)))
    assert found == [pytest.approx((inner, 0.04)), (radius, 0.002)]


# the axles of the burger, by 1.57, and by the same angle to the other side
LEAN, OTHER = 1.57, 1.5716


@pytest.mark.parametrize('left, right, length, origin, has_tread', [
    (UPRIGHT, UPRIGHT, 0.018, '', True), (UPRIGHT, UPRIGHT, 0.0021, '', True),
    (UPRIGHT, UPRIGHT, 0.002, '', False),
    (LEAN, LEAN, 0.018, '', False), (LEAN, LEAN, 0.02, '', False),
    (LEAN, LEAN, 0.0201, '', True), (OTHER, OTHER, 0.018, '', False),
    # axles that point to each other
    (LEAN, -LEAN, 0.018, '', True), (LEAN, -OTHER, 0.018, '', False),
    (-LEAN, OTHER, 0.018, '', False),
    (LEAN, OTHER, 0.018, '', True), (OTHER, LEAN, 0.018, '', True),
    (LEAN, UPRIGHT, 0.018, '', True), (UPRIGHT, OTHER, 0.018, '', True),
    # cylinders that are not about the axle touch the floor elsewhere
    (LEAN, LEAN, 0.018, '0.01 0 0', True), (LEAN, LEAN, 0.018, '0.00001 0 0', False),
    (LEAN, LEAN, 0.018, '3.141592653589793 0 0', False),
    (LEAN, LEAN, 0.04, '3.141592653589793 0 0', True),
    (UPRIGHT, UPRIGHT, 0.04, '0.1 0 0', True), (UPRIGHT, UPRIGHT, 0.04, '0 0.2 0', False),
    (UPRIGHT, UPRIGHT, 0.04, '0 1.5707963267948966 0', False)])
def test_which_wheels_need_a_tread(left, right, length, origin, has_tread):
    urdf = robot(left, right, ROUND.format(0.1, length),
                 '<origin xyz="0 0 0" rpy="{}"/>'.format(origin or '0 0 0'))
    assert [len(cylinders(urdf, name=name + '_wheel')) for name in JOINTS] == [1 + has_tread] * 2


@pytest.mark.parametrize('urdf, joints', [
    (robot(), ()), (robot(), ('other',)), (robot(shape='<sphere radius="0.1"/>'), JOINTS)])
def test_what_is_no_wide_wheel_stays_as_it_is(urdf, joints):
    before = given(urdf)
    after = tyres.added(before, joints, 0.0)
    assert (after.links, after.joints) == (before.links, before.joints)


def test_only_the_wheels_of_the_joints_are_changed():
    assert len(cylinders(robot(), ('right',))) == 1
    assert len(cylinders(robot(), ('right',), 'right_wheel')) == 2


def test_a_wheel_that_slips_can_move_along_its_axle():
    found = added(robot(axis='0 3 4'), ('left',), 0.3)
    assert [joint.name for joint in found.joints] == ['left', 'right', 'left/tyre']
    wheel, _, side = found.joints
    assert (wheel.parent, wheel.child) == ('left/tyre', 'left_wheel')
    assert (side.kind, side.parent, side.child) == ('prismatic', 'base', 'left/tyre')
    assert side.axis.tolist() == [0, 0.6, 0.8]
    assert side.limits == (-1, 1, 1e6, 1e3)
    assert side.pose.translation.tolist() == [0.1, 0.2, 0.3]
    assert side.pose.rotation[1] == pytest.approx((0, 0, 1))
    assert wheel.pose.matrix().tolist() == np.eye(4).tolist()


# ixx, which is the least, has to be mass times the square of the radius
@pytest.mark.parametrize('radius, moments', [
    (0.3, (0.018, 0.028, 0.038)), (0.2, (0.01, 0.02, 0.03))])
def test_mass_and_inertia_of_a_wheel_that_slips(radius, moments):
    found = added(robot(), ('left',), radius)
    wheel, other, tyre = (each.inertia for each in found.links[1:])
    assert [each.mass for each in (wheel, other, tyre)] == pytest.approx([0.18, 0.2, 0.02])
    assert [*wheel.matrix.diagonal(), wheel.matrix[0, 1]] == pytest.approx([*moments, 0.001])
    assert other.matrix[0, 0] == 0.01
    assert tyre.matrix.diagonal() == pytest.approx([2e-5] * 3)


@pytest.mark.parametrize('axis, rpy', [
    ((0, 0, 1), (0, 0, 0)), ((1, 0, 0), (0, math.pi / 2, 0)), ((0, 1, 0), (-math.pi / 2, 0, 0)),
    ((0.48, 0.6, 0.64), (0, math.acos(0.64), math.atan2(0.6, 0.48)))])
def test_a_mesh_becomes_a_cylinder_about_the_axle(axis, rpy, tmp_path):
    path = tmp_path / 'wheel.obj'
    path.write_text(wheel_mesh(0.08, width=0.05))
    # 0.03 m along the axle
    origin = '<origin xyz="{} {} {}" rpy="{} {} {}"/>'.format(*(0.03 * each for each in axis),
                                                              *rpy)
    urdf = robot(shape='<mesh filename="{}"/>'.format(path), origin=origin,
                 axis='{} {} {}'.format(*axis))
    assert cylinders(urdf) == [pytest.approx((0.0599, 0.05)), (0.08, 0.002)]
    wheel = part(added(urdf).links, 'left_wheel')
    for solid in wheel.solids:
        assert solid.pose.translation == pytest.approx([0.03 * each for each in axis])
        assert solid.pose.rotation[:, 2] == pytest.approx(axis)


def test_the_cylinder_is_where_the_mesh_is_in_its_file(tmp_path):
    path = tmp_path / 'wheel.obj'
    about_z = (line.split() for line in wheel_mesh(0.08, width=0.05).splitlines())
    path.write_text('\n'.join(
        'v {} {} {}'.format(float(words[3]) + 0.03, words[1], words[2]) if words[0] == 'v'
        else ' '.join(words) for words in about_z))
    pose = part(added(robot(shape='<mesh filename="{}"/>'.format(path), axis='-1 0 0')).links,
                'left_wheel').solids[0].pose
    assert pose.translation == pytest.approx((0.03, 0, 0))
    assert pose.rotation[:, 2] == pytest.approx((-1, 0, 0))


def test_a_mesh_that_is_not_round_stays_one(tmp_path):
    path = tmp_path / 'wheel.obj'
    path.write_text(wheel_mesh(0.08, (0.03, 0.0)))
    urdf = robot(shape='<mesh filename="{}"/>'.format(path))
    solid, = part(added(urdf).links, 'left_wheel').solids
    assert solid.shape.kind == MESH and cylinders(urdf) == []
