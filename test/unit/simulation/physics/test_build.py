"""Physics clients, and models that are built in them."""
import math
import os

import numpy as np
import pybullet
import pytest
from PIL import Image

from img_recog.formats.meshes import mesh_file
from img_recog.model import (BOX, FIXED, PLANE, SPHERE, WHOLE, Joint, Link, Look, Material, Model,
                             Shape, Submesh)
from img_recog.rotations import IDENTITY, transform
from img_recog.simulation.physics import build, mesh_cache
from img_recog.simulation.physics.client import connect
from img_recog_helpers.parsed import given
from img_recog_helpers.refusals import refusal


@pytest.mark.parametrize('number', [-1, 0, 7])
def test_first_client_has_the_number_0_and_a_negative_one_is_an_error(number, monkeypatch):
    monkeypatch.setattr(pybullet, 'connect', lambda mode: number)
    monkeypatch.setattr(pybullet, 'setPhysicsEngineParameter', lambda **values: None)
    if number >= 0:
        assert connect() == number
    else:
        assert 'cannot start a physics client' in refusal(connect)


def loaded(model, **more):
    """Return the number of a model in a client, and how that is given to PyBullet."""
    client = connect()
    return build.load(model, client, **more), {'physicsClientId': client}


def seen(model, *flags, **more):
    body, client = loaded(model, visuals=True, **more)
    return pybullet.getVisualShapeData(body, *flags, **client)


@pytest.mark.parametrize('padding', range(0, 40, 4))
def test_a_long_line_is_not_broken(padding):
    # the position of a visual stands at or near byte 8192 of what PyBullet reads
    box, place = Look(Shape(BOX, (1.0, 1.0, 1.0))), (1.23456789, 2.34567891, 3.45678912)
    ball = Look(Shape(SPHERE, (1.0,)), IDENTITY._replace(translation=np.array(place)))
    count = 38
    name = 'l' * (300 + 4 * padding)
    data = seen(Model('r', (Link(name, looks=(box,) * count + (ball,) * 4),)))
    assert len(data) == count + 4
    for each in data[count:]:
        assert each[5] == pytest.approx(place)


@pytest.mark.parametrize('key, kind', [
    ('robot', 'robot or model'), ('link', 'link'), ('joint', 'joint')])
def test_names_that_would_crash_pybullet(key, kind):
    def model(robot, link, joint):
        return Model(robot, (Link(link), Link('b')), (Joint(joint, FIXED, link, 'b'),))
    longest = {'robot': 'r', 'link': 'a', 'joint': 'j', key: '\u00e4' * 250}
    body, client = loaded(model(**longest), fixed=True)
    assert pybullet.getNumJoints(body, **client) == 1
    longest[key] += 'x'
    assert refusal(loaded, model(**longest), fixed=True) == (
        'the name of a {} that begins with {} has 501 bytes, allowed are 500; give a shorter name'
        .format(kind, '\u00e4' * 40))


INERTIAL = ('<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
            '</inertial>')
SHAPE = '<{0}><geometry>{1}</geometry></{0}>'
TWO_BOXES = ''.join(
    'o {0}\nv {1} 0 0\nv {2} 0 0\nv {1} 1 0\nv {1} 0 1\nf {3} {5} {4}\nf {3} {4} {6}\n'
    'f {3} {6} {5}\nf {4} {5} {6}\n'.format(name, x, x + 1, *range(first, first + 4))
    for name, x, first in (('a', 0, 1), ('b', 5, 5)))


def robot(*shapes):
    return given('<robot name="r"><link name="a">{}{}</link></robot>'.format(
        INERTIAL, ''.join(shapes)), str)


def mesh(tag, path):
    return SHAPE.format(tag, '<mesh filename="{}"/>'.format(path))


def test_visual_meshes_that_cannot_be_read_are_not_seen(tmp_path):
    (tmp_path / 'a.dae').write_text('<COLLADA/>')
    visual = mesh('visual', tmp_path / 'a.dae')
    model = given(
        '<robot name="r"><link name="a">{0}{1}</link><link name="b">{0}</link><joint name="j" '
        'type="fixed"><parent link="a"/><child link="b"/></joint></robot>'.format(
            visual, SHAPE.format('visual', '<box size="1 2 3"/>')), str)
    assert [data[1:4] for data in seen(model, fixed=True)] == [
        (-1, pybullet.GEOM_BOX, (1, 2, 3)), (0, pybullet.GEOM_BOX, (0, 0, 0))]


def test_a_visual_obj_has_its_texture(tmp_path):
    Image.new('RGB', (2, 2), (10, 20, 30)).save(str(tmp_path / 'a.png'))
    (tmp_path / 'a.mtl').write_text('newmtl {}\nmap_Kd a.png\n'.format('m' * 5000))
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\n'
                                    'vt 0 1\nusemtl {}\nf 1/1 2/2 3/3\n'.format('m' * 5000))
    data, = seen(robot(mesh('visual', tmp_path / 'a.obj')),
                 pybullet.VISUAL_SHAPE_DATA_TEXTURE_UNIQUE_IDS)
    assert data[8] >= 0


def test_a_damaged_mesh_is_not_given_to_pybullet(tmp_path, capfd):
    (tmp_path / 'a.stl').write_bytes(bytes(133))
    client = connect()
    capfd.readouterr()
    assert refusal(build.load, robot(mesh('collision', tmp_path / 'a.stl')), client
                   ).startswith('cannot read the mesh {}: '.format(tmp_path / 'a.stl'))
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize('is_concave', [False, True])
def test_objects_of_an_obj_are_not_joined(tmp_path, is_concave):
    (tmp_path / 'a.obj').write_text(TWO_BOXES)
    link, = robot(mesh('collision', tmp_path / 'a.obj')).links
    solids = (link.solids[0]._replace(is_concave=is_concave),)
    client, files = connect(), len(os.listdir('/proc/self/fd'))
    body = build.load(Model('r', (link._replace(solids=solids),)), client, fixed=True)
    assert len(os.listdir('/proc/self/fd')) == files
    found = pybullet.rayTestBatch([(x, 0.1, 3) for x in (0.1, 3, 5.1)],
                                  [(x, 0.1, -3) for x in (0.1, 3, 5.1)], physicsClientId=client)
    assert [hit[0] for hit in found] == [body, -1, body]


def test_a_mesh_is_read_again_only_when_its_content_changes(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    written = []
    write = mesh_file.write
    monkeypatch.setattr(mesh_file, 'write', lambda *args, **more: (
        written.append(args) or write(*args, **more)))
    (tmp_path / 'a.obj').write_text(TWO_BOXES)
    first = mesh_cache.cached(str(tmp_path / 'a.obj'))
    assert os.path.dirname(os.path.dirname(first)) == str(tmp_path / 'cache' / 'img_recog')
    os.rename(str(tmp_path / 'a.obj'), str(tmp_path / 'b.obj'))
    assert mesh_cache.cached(str(tmp_path / 'b.obj')) == first and len(written) == 1
    (tmp_path / 'b.obj').write_text(TWO_BOXES.replace('v 5', 'v 6'))
    second = mesh_cache.cached(str(tmp_path / 'b.obj'))
    assert len(written) == 2
    assert sorted(os.listdir(os.path.dirname(second))) == sorted(map(os.path.basename,
                                                                     (first, second)))


def test_a_part_of_a_mesh_is_another_file(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    path = str(tmp_path / 'a.obj')
    (tmp_path / 'a.obj').write_text(TWO_BOXES)
    assert refusal(mesh_cache.cached, path, Submesh('c')) == (
        'the mesh has no submesh c; its submeshes are: a, b')
    for submesh, low, high in ((WHOLE, 0, 6), (Submesh('a'), 0, 1), (Submesh('b'), 5, 6),
                               (Submesh('b', is_centered=True), -0.5, 0.5)):
        parts = mesh_file.read(mesh_cache.cached(path, submesh))
        assert min(part.positions[..., 0].min() for part in parts) == low
        assert max(part.positions[..., 0].max() for part in parts) == high


def test_a_cache_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    (tmp_path / 'file').write_text('')
    (tmp_path / 'a.obj').write_text(TWO_BOXES)
    line = refusal(mesh_cache.cached, str(tmp_path / 'a.obj'))
    assert line.startswith('cannot write to {}/file/'.format(tmp_path))
    assert line.endswith(': Not a directory; set XDG_CACHE_HOME to a folder where files can be '
                         'written')


def test_what_pybullets_own_elements_and_joints_say_is_simulated():
    model = given(
        '<robot name="r"><link name="a"/><link name="b">' + INERTIAL
        + SHAPE.format('collision', '<capsule radius="0.5" length="2"/>')
        + '<contact><restitution value="0.75"/><lateral_friction value="0.25"/></contact></link>'
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="2" effort="3" velocity="4"/><dynamics damping="5" friction="6"/>'
        '</joint></robot>')
    body, client = loaded(model, fixed=True)
    assert pybullet.getJointInfo(body, 0, **client)[6:12] == (5, 6, -1, 2, 3, 4)
    dynamics = pybullet.getDynamicsInfo(body, 0, **client)
    assert (dynamics[1], dynamics[5]) == (0.25, 0.75)
    shape, = pybullet.getCollisionShapeData(body, 0, **client)
    assert (shape[2], shape[3][:2]) == (pybullet.GEOM_CAPSULE, (2, 0.5))


def test_each_shape_of_a_link_in_the_window_has_its_own_color():
    reds = (0.5, 0.625, 0.5)
    looks = tuple(Look(Shape(BOX, (1.0, 1.0, 1.0)), material=Material((red, 0.0, 0.0, 1.0)))
                  for red in reds)
    data = seen(Model('r', tuple(
        Link('link_{}'.format(number), looks=(look,)) for number, look in enumerate(looks)), tuple(
            Joint('j_{}'.format(number), FIXED, 'link_0', 'link_{}'.format(number))
            for number in (1, 2))))
    assert [each[7][0] for each in data] == list(reds)


def test_a_plane_is_seen_as_the_upper_side_of_a_thin_box():
    turned = transform((1, 2, 3), (0.0, math.pi / 2, 0.0))
    shape, = seen(Model('r', (Link('a', looks=(Look(Shape(PLANE, (4.0, 2.0)), turned),)),)),
                  fixed=True)
    assert shape[2] == pybullet.GEOM_BOX and shape[3] == pytest.approx((4, 2, 0.01))
    assert shape[5] == pytest.approx((1 - 0.005, 2, 3))


def test_more_joints_than_pybullet_has_are_refused():
    links = [Link('l{}'.format(number)) for number in range(129)]
    joints = [Joint('j{}'.format(number), FIXED, 'l0', 'l{}'.format(number))
              for number in range(1, 129)]
    assert refusal(loaded, Model('m', tuple(links), tuple(joints))) == (
        'it has 128 joints, and PyBullet takes at most 127; divide it into several models')
    body, client = loaded(Model('m', tuple(links[:128]), tuple(joints[:127])))
    assert pybullet.getBasePositionAndOrientation(body, **client)
