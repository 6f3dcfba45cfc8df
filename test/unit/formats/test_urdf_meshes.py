"""Meshes of a robot description: found, missing and replaced; and a robot that has them."""
import os
import struct

import pytest

from img_recog.model import BOX, CYLINDER, MESH, Material, Shape
from img_recog_helpers.parsed import given, lumped, part
from img_recog_helpers.robots import read

INERTIAL = ('<inertial><mass value="{}"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" '
            'izz="0.001"/></inertial>')
SHAPE = '<{0}><origin xyz="{1}" rpy="{2}"/><geometry>{3}</geometry>{4}</{0}>'
FILE = '<mesh filename="package://toy/meshes/{}" scale="0.001 0.001 0.001"/>'
BLUE = '<material name="blue"><color rgba="0 0 1 1"/></material>'
JOINT = ('<joint name="{1}_joint" type="{0}"><parent link="{2}"/><child link="{1}"/>'
         '<origin xyz="{3}" rpy="{4}"/><axis xyz="0 0 1"/></joint>')


def toy_link(name, mass, *shapes):
    return '<link name="{}">{}{}</link>'.format(name, INERTIAL.format(mass), ''.join(shapes))


def primitive(origin, geometry):
    return SHAPE.format('collision', origin, '0 0 0', geometry, '')


def mesh(kind, file='a.stl', inside='', origin='0 0 0'):
    return SHAPE.format(kind, origin, '0 0 0', FILE.format(file), inside)


# like turtlebot3_description: visual shapes are STL in mm, collision shapes are primitives
TOY = '<robot name="toy"><link name="base_footprint"/><link name="imu_link"/>{}</robot>'.format(
    ''.join((
        toy_link('base_link', 0.8, mesh('visual', 'base.stl', BLUE, '-0.032 0 0'),
                 primitive('-0.032 0 0.07', '<box size="0.14 0.14 0.14"/>')),
        toy_link('base_scan', 0.1, mesh('visual', 'lds.stl'), mesh('collision', 'lds.stl')),
        toy_link('caster_link', 0.005, primitive('0 0 0', '<box size="0.03 0.009 0.02"/>')),
        JOINT.format('fixed', 'base_link', 'base_footprint', '0 0 0.01', '0 0 0'),
        JOINT.format('fixed', 'imu_link', 'base_link', '0 0 0.07', '0 0 0'),
        JOINT.format('fixed', 'base_scan', 'base_link', '-0.032 0 0.172', '0 0 0'),
        JOINT.format('fixed', 'caster_link', 'base_link', '-0.081 0 0', '0 0 0'),
        *(toy_link(name, 0.03, mesh('visual', 'wheel.stl'),
                   primitive('0 0 0', '<cylinder length="0.018" radius="0.033"/>'))
          + JOINT.format('continuous', name, 'base_link', '0 {} 0.023'.format(y), '-1.5707963 0 0')
          for name, y in (('wheel_left', 0.08), ('wheel_right', -0.08))))))
URIS = ['package://toy/meshes/{}.stl'.format(name) for name in ('base', 'wheel', 'lds')]


@pytest.fixture
def find(tmp_path):
    """Where package://toy is, with a tetrahedron of 100 (mm) in each of its meshes."""
    corners = [(0, 0, 0), (100, 0, 0), (0, 100, 0), (0, 0, 100)]
    for uri in URIS:
        with open(str(tmp_path / os.path.basename(uri)), 'wb') as file:
            file.write(bytes(80) + struct.pack('<I', 4))
            for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
                points = [value for corner in face for value in corners[corner]]
                file.write(struct.pack('<12fH', 0, 0, 0, *points, 0))
    return {uri: str(tmp_path / os.path.basename(uri)) for uri in URIS}.get


def resolved(inside, find=lambda uri: None):
    """Read one link; return it and the meshes that are missing."""
    robot = given('<robot><link name="l">{}</link></robot>'.format(inside), find)
    return robot.links[0], list(robot.missing_meshes)


def box(kind, size=1):
    return SHAPE.format(kind, '1 2 3', '0.1 0 0', '<box size="{0} {0} {0}"/>'.format(size), '')


def shapes(parts):
    return [each.shape for each in parts]


def test_found_meshes_become_absolute_paths_and_keep_their_scale(find, tmp_path):
    robot = lumped(TOY, find)
    assert robot.missing_meshes == ()
    found = [shape for link in robot.links for shape in shapes(link.looks + link.solids)
             if shape.kind == MESH]
    assert sorted(shape.path for shape in found) == sorted(
        str(tmp_path / name) for name in ('base.stl', 'wheel.stl', 'wheel.stl', 'lds.stl',
                                          'lds.stl'))
    assert {shape.size for shape in found} == {(0.001, 0.001, 0.001)}


def test_relative_path_that_was_found_becomes_absolute(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    link, missing = resolved(mesh('visual'), lambda uri: 'b/a.STL')
    assert link.looks[0].shape.path == str(tmp_path / 'b' / 'a.STL') and missing == []
    of_sdf = '<visual><geometry><mesh><uri> model://b/a.dae </uri></mesh></geometry></visual>'
    link, missing = resolved(of_sdf, {'model://b/a.dae': 'b/a.dae'}.get)
    assert link.looks[0].shape.path == str(tmp_path / 'b' / 'a.dae') and missing == []


def test_collision_shape_replaces_a_missing_visual_in_its_color():
    link, missing = resolved(mesh('visual', inside=BLUE) + box('collision') + box('collision', 2))
    assert shapes(link.looks) == [Shape(BOX, (1, 1, 1)), Shape(BOX, (2, 2, 2))]
    assert {look.material for look in link.looks} == {Material((0, 0, 1, 1))}
    assert all(look.pose.translation.tolist() == [1, 2, 3] and look.pose.rotation[2, 1] > 0.09
               for look in link.looks)
    assert len(link.solids) == 2 and missing == ['package://toy/meshes/a.stl']


def test_visual_shape_replaces_a_missing_collision():
    link, _ = resolved(mesh('collision') + box('visual').replace('</visual>', BLUE + '</visual>'))
    assert shapes(link.solids) == shapes(link.looks) == [Shape(BOX, (1, 1, 1))]
    assert link.solids[0].pose.translation.tolist() == [1, 2, 3]


def test_no_replacement_where_a_shape_is_left_or_there_is_none():
    link, _ = resolved(mesh('visual') + box('visual', 3) + box('collision'))
    assert shapes(link.looks + link.solids) == [Shape(BOX, (3, 3, 3)), Shape(BOX, (1, 1, 1))]
    link, missing = resolved(mesh('visual') + mesh('collision'))
    assert link.looks + link.solids == () and missing == ['package://toy/meshes/a.stl']
    link, missing = resolved(box('collision'))      # is invisible on purpose
    assert link.looks == () and missing == []


def test_missing_meshes_are_listed_once_and_replaced():
    robot = lumped(TOY)
    assert sorted(robot.missing_meshes) == sorted(URIS)
    wheel = part(robot.links, 'wheel_left')
    assert shapes(wheel.looks) == [Shape(CYLINDER, (0.033, 0.018))]
    line, = read(TOY).warnings
    assert all(uri in line for uri in URIS) and '\n' not in line


@pytest.mark.parametrize('name, readable', [
    ('a.stl', True), ('a.STL', True), ('a.dae', True), ('a.obj', True), ('a.ply', False),
    ('a', False), ('a.stl.gz', False)])
def test_what_pybullet_cannot_read_counts_as_missing(name, readable):
    link, missing = resolved(mesh('visual', name), lambda uri: '/m/' + name)
    assert len(link.looks) == readable
    assert missing == ([] if readable else ['package://toy/meshes/' + name])


def test_replacements_have_the_material_of_the_first_shape_that_is_missing():
    missing = ('<visual><geometry><mesh filename="{0}"/></geometry><material name="{0}">'
               '<color rgba="{1} 0 0 1"/></material></visual>')
    link, names = resolved(missing.format('b', 0.5) + missing.format('c', 0.25) + box('collision'))
    assert names == ['b', 'c']
    assert [look.material.color for look in link.looks] == [(0.5, 0, 0, 1)]
