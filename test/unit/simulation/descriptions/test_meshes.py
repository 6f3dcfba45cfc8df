"""Meshes of a robot description: found, missing and replaced; and a robot that has them."""
import math
import os
import struct
import xml.etree.ElementTree as ElementTree

import pybullet
import pytest

from img_recog.simulation.bodies import loading
from img_recog.simulation.descriptions import meshes
from img_recog.simulation.descriptions.description import parse
from img_recog.simulation.settings import RobotSettings, SpawnSettings
from img_recog.simulation.vehicle import Vehicle
from img_recog_testing.robots import simulator

INERTIAL = ('<inertial><mass value="{}"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" '
            'izz="0.001"/></inertial>')
SHAPE = '<{0}><origin xyz="{1}" rpy="{2}"/><geometry>{3}</geometry>{4}</{0}>'
MESH = '<mesh filename="package://toy/meshes/{}" scale="0.001 0.001 0.001"/>'
BLUE = '<material name="blue"><color rgba="0 0 1 1"/></material>'
JOINT = ('<joint name="{1}_joint" type="{0}"><parent link="{2}"/><child link="{1}"/>'
         '<origin xyz="{3}" rpy="{4}"/><axis xyz="0 0 1"/></joint>')


def toy_link(name, mass, *shapes):
    return '<link name="{}">{}{}</link>'.format(name, INERTIAL.format(mass), ''.join(shapes))


def primitive(origin, geometry):
    return SHAPE.format('collision', origin, '0 0 0', geometry, '')


def mesh(kind, file='a.stl', inside='', origin='0 0 0'):
    return SHAPE.format(kind, origin, '0 0 0', MESH.format(file), inside)


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
    """Resolve the meshes of one link; return it and what is missing."""
    robot = ElementTree.fromstring('<robot><link name="l">{}</link></robot>'.format(inside))
    missing = meshes.resolve(robot, find)
    return robot.find('link'), missing


def box(kind, size=1):
    return SHAPE.format(kind, '1 2 3', '0.1 0 0', '<box size="{0} {0} {0}"/>'.format(size), '')


def test_found_meshes_become_absolute_paths_and_keep_their_scale(find, tmp_path):
    description = parse(TOY, find)
    assert description.missing_meshes == ()
    found = list(ElementTree.fromstring(description.urdf).iter('mesh'))
    assert sorted(each.get('filename') for each in found) == sorted(
        str(tmp_path / name) for name in ('base.stl', 'wheel.stl', 'wheel.stl', 'lds.stl',
                                          'lds.stl'))
    assert {each.get('scale') for each in found} == {'0.001 0.001 0.001'}


def test_relative_path_that_was_found_becomes_absolute(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    link, missing = resolved(mesh('visual'), lambda uri: 'b/a.STL')
    assert link.find('visual/geometry/mesh').get('filename') == str(tmp_path / 'b' / 'a.STL')
    assert missing == []
    of_sdf = '<visual><geometry><mesh><uri> model://b/a.dae </uri></mesh></geometry></visual>'
    link, missing = resolved(of_sdf, {'model://b/a.dae': 'b/a.dae'}.get)
    assert link.findtext('visual/geometry/mesh/uri') == str(tmp_path / 'b' / 'a.dae')
    assert missing == []


def test_pybullet_loads_the_meshes(find):
    client = loading.connect()
    body = loading.load_urdf(parse(TOY, find).urdf, client, visuals=True)
    scales = [shape[3] for shape in pybullet.getVisualShapeData(body, physicsClientId=client)
              if shape[2] == pybullet.GEOM_MESH]
    assert len(scales) == 4
    assert all(scale == pytest.approx((0.001, 0.001, 0.001)) for scale in scales)
    # from above onto the scanner, whose tetrahedron is 0.1 m high at its corner
    hit, = pybullet.rayTestBatch([(-0.022, 0.01, 1.0)], [(-0.022, 0.01, 0.0)],
                                 physicsClientId=client)
    assert hit[0] == body
    assert hit[3] == pytest.approx((-0.022, 0.01, 0.182 + 0.08), abs=3e-3)


def test_collision_shape_replaces_a_missing_visual_in_its_color():
    link, missing = resolved(mesh('visual', inside=BLUE) + box('collision') + box('collision', 2))
    visuals = link.findall('visual')
    assert [each.find('geometry/box').get('size') for each in visuals] == ['1 1 1', '2 2 2']
    assert {each.find('material').get('name') for each in visuals} == {'blue'}
    assert all(each.find('origin').attrib == {'xyz': '1 2 3', 'rpy': '0.1 0 0'}
               for each in visuals)
    assert len(link.findall('collision')) == 2 and link.find('collision/material') is None
    assert missing == ['package://toy/meshes/a.stl']


def test_visual_shape_replaces_a_missing_collision():
    link, _ = resolved(mesh('collision') + box('visual').replace('</visual>', BLUE + '</visual>'))
    assert link.find('collision/geometry/box').get('size') == '1 1 1'
    assert link.find('collision/origin').get('xyz') == '1 2 3'
    assert link.find('collision/material') is None
    assert len(link.findall('collision')) == len(link.findall('visual')) == 1


def test_no_replacement_where_a_shape_is_left_or_there_is_none():
    link, _ = resolved(mesh('visual') + box('visual', 3) + box('collision'))
    assert [each.get('size') for each in link.iter('box')] == ['3 3 3', '1 1 1']
    link, missing = resolved(mesh('visual') + mesh('collision'))
    assert len(link) == 0 and missing == ['package://toy/meshes/a.stl']
    link, missing = resolved(box('collision'))      # is invisible on purpose
    assert link.find('visual') is None and missing == []


def test_missing_meshes_are_listed_once_and_replaced():
    description = parse(TOY)
    assert sorted(description.missing_meshes) == sorted(URIS)
    urdf = ElementTree.fromstring(description.urdf)
    assert list(urdf.iter('mesh')) == []
    wheel = next(each for each in urdf.findall('link') if each.get('name') == 'wheel_left')
    assert wheel.find('visual/geometry/cylinder').get('radius') == '0.033'
    words = meshes.warning_about(description.missing_meshes)
    assert all(uri in words for uri in URIS) and '\n' not in words


@pytest.mark.parametrize('name, readable', [
    ('a.stl', True), ('a.STL', True), ('a.dae', True), ('a.obj', True), ('a.ply', False),
    ('a', False), ('a.stl.gz', False)])
def test_what_pybullet_cannot_read_counts_as_missing(name, readable):
    link, missing = resolved(mesh('visual', name), lambda uri: '/m/' + name)
    assert (link.find('visual') is not None) is readable
    assert missing == ([] if readable else ['package://toy/meshes/' + name])


@pytest.mark.parametrize('has_meshes', [True, False])
def test_robot_weighs_what_it_says_and_stands_and_drives(find, has_meshes):
    sim = simulator()
    description = parse(TOY, find if has_meshes else lambda uri: None)
    settings = RobotSettings(spawn=SpawnSettings(x_pos=1.0, y_pos=1.0))
    sim.remove(sim.vehicles[0])
    toy = Vehicle(description, settings, sim.world)
    sim.add(toy)
    assert toy.robot.mass() == pytest.approx(0.8 + 2 * 0.03 + 0.1 + 0.005, abs=1e-6)
    sim.advance(2000)
    stands = toy.robot.motion()
    assert stands.position == pytest.approx([1.0, 1.0, 0.0], abs=0.005)
    assert 2 * math.acos(min(1.0, abs(stands.orientation[3]))) < 0.05
    assert stands.linear == pytest.approx([0, 0, 0], abs=1e-3)
    toy.command(0.2, 0.0)
    sim.advance(2000)
    assert toy.robot.motion().linear[0] == pytest.approx(0.2, rel=0.05)


def test_replacements_have_the_material_of_the_first_shape_that_is_missing():
    missing = ('<visual><geometry><mesh filename="{0}"/></geometry><material name="{0}"/>'
               '</visual>')
    link = ElementTree.fromstring(
        '<robot><link name="a">' + missing.format('b') + missing.format('c')
        + '<collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>')
    assert meshes.resolve(link, lambda uri: None) == ['b', 'c']
    assert [visual.find('material').get('name') for visual in link.iter('visual')] == ['b']
    assert link.find('link/visual').get('name') == 'replacement_0'
