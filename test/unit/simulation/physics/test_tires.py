"""What is added to a robot for its wheels, to the digit."""
import math

import pytest

from img_recog.model import CYLINDER
from img_recog.simulation.physics import tires
from img_recog_helpers.parsed import given, part
from img_recog_helpers.wheeled import wheel_mesh

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


def added(urdf, joints=JOINTS):
    return tires.added(given(urdf, lambda uri: uri), joints)


def cylinders(urdf, joints=JOINTS, name='left_wheel'):
    """Return radius and length of the cylinders of a wheel."""
    return [solid.shape.size for solid in part(added(urdf, joints).links, name).solids
            if solid.shape.kind == CYLINDER]


def treads(urdf, name):
    """Return the treads of a wheel, each a solid of a link of its own."""
    return [solid for link in added(urdf).links for solid in link.solids
            if link.name.startswith(name + tires.TREAD)]


def places(urdf, name):
    """Return where the treads of a wheel are along its axle, and check that they are narrow."""
    found = treads(urdf, name)
    assert [solid.shape.size for solid in found] == [
        pytest.approx((0.1, 0.002), abs=1e-5)] * len(found)
    return [round(float(solid.pose.translation[2]), 6) for solid in found]


def with_four_wheels(urdf, roll=UPRIGHT):
    return urdf.replace('</robot>', ''.join(
        WHEEL.format(name, INERTIAL, '', ROUND.format(0.1, 0.04), roll, '0 0 1')
        for name in ('third', 'fourth')) + '</robot>')


def test_a_wheel_stays_whole_and_has_narrow_treads():
    urdf = robot(shape=ROUND.format(0.1, 0.04))
    assert cylinders(urdf) == [(0.1, 0.04)]
    assert [solid.shape.size for solid in treads(urdf, 'left_wheel')] == [(0.1, 0.002)] * 2


def test_the_outer_tread_of_more_than_two_wheels_is_lower():
    # z of the wheels points to the left, where all are
    assert [solid.shape.size for solid in treads(with_four_wheels(robot()), 'left_wheel')] == [
        (0.1, 0.002), (pytest.approx(0.1 - 2e-6, abs=1e-9), 0.002)]


def test_treads_of_light_wheels_are_at_one_height():
    """They lean in Gazebo, so that both edges bear the robot."""
    light = INERTIAL.replace('0.0', '0.0000')
    urdf = with_four_wheels(robot()).replace(INERTIAL, light)
    assert light != INERTIAL
    assert len({solid.shape.size for solid in treads(urdf, 'left_wheel')}) == 1


def test_a_wheel_with_a_direction_of_friction_has_each_tread_twice():
    urdf = robot().replace('</robot>', '<gazebo reference="left_wheel"><fdir1>1 0 0</fdir1>'
                           '</gazebo></robot>')
    names = [link.name for link in added(urdf).links if tires.TREAD in link.name]
    assert names == ['left_wheel::tread_0', 'left_wheel::tread_0_across', 'left_wheel::tread_1',
                     'left_wheel::tread_1_across', 'right_wheel::tread_0', 'right_wheel::tread_1']


def test_treads_of_more_than_two_wheels_are_at_both_edges_however_they_lean():
    urdf = with_four_wheels(robot(1.57, 1.57), 1.57)
    assert len(treads(urdf, 'third_wheel')) == len(treads(urdf, 'left_wheel')) == 2


# the axles of the burger, by 1.57, and by the same angle to the other side
LEAN, OTHER = 1.57, 1.5716


@pytest.mark.parametrize('roll, length, ends', [
    (UPRIGHT, 0.04, [0.019, -0.019]), (UPRIGHT, 0.018, [0.008, -0.008]), (UPRIGHT, 0.002, []),
    (-1.57075, 0.04, [0.019, -0.019]),
    # one edge is lower than the other: 1.57 turns z to -y, and a little up
    (LEAN, 0.04, [-0.019]), (OTHER, 0.04, [0.019]), (-LEAN, 0.018, [-0.008]),
    (-OTHER, 0.018, [0.008])])
def test_a_wheel_touches_the_floor_with_both_edges_or_with_the_lower_one(roll, length, ends):
    urdf = robot(roll, roll, ROUND.format(0.1, length))
    assert [places(urdf, name + '_wheel') for name in JOINTS] == [ends] * 2


@pytest.mark.parametrize('changes', [
    {'origin': '<origin xyz="0 0 0" rpy="0.2 0 0"/>'},      # not about the axle
    {'origin': '<origin xyz="0 0 0" rpy="0 1.5707963267948966 0"/>'},
    {'shape': '<sphere radius="0.1"/>'}, {'shape': '<mesh filename="{}"/>'}])      # not round
def test_what_is_no_wheel_stays_as_it_is(changes, tmp_path):
    path = tmp_path / 'wheel.obj'
    path.write_text(wheel_mesh(0.08, (0.03, 0.0)))
    before = given(robot(**changes).replace('{}', str(path)), lambda uri: uri)
    assert [link.solids for link in tires.added(before, JOINTS).links] == [
        link.solids for link in before.links]


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
    assert cylinders(urdf) == [pytest.approx((0.08, 0.05))]
    wheel = part(added(urdf).links, 'left_wheel')
    assert wheel.solids[0].pose.translation == pytest.approx([0.03 * each for each in axis])
    for solid in (*wheel.solids, *treads(urdf, 'left_wheel')):
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
