"""Physics clients."""
import os

import pybullet
import pytest
from PIL import Image

from img_recog import mesh_file
from img_recog.simulation.bodies import loading, mesh_cache
from img_recog.simulation.settings import SimulationError
from img_recog.visuals import WHOLE, Submesh
from img_recog_testing.refusals import refusal


@pytest.fixture(params=[-1, 0, 7])
def number(request, monkeypatch):
    """The number of the client that PyBullet gives; a negative one means that it has none."""
    monkeypatch.setattr(pybullet, 'connect', lambda mode: request.param)
    monkeypatch.setattr(pybullet, 'setPhysicsEngineParameter', lambda **values: None)
    return request.param


def test_first_client_has_the_number_0_and_a_negative_one_is_an_error(number):
    if number >= 0:
        assert loading.connect() == number
    else:
        with pytest.raises(SimulationError, match='cannot start a physics client'):
            loading.connect()


@pytest.mark.parametrize('padding', range(0, 40, 4))
def test_a_long_line_is_not_broken(padding):
    # the position of a visual stands at or near byte 8192
    begin = ('<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
             'ixz="0" iyy="1" iyz="0" izz="1"/></inertial>')
    shape = '<geometry><sphere radius="1"/></geometry>'
    visual = '<visual><origin xyz="1.23456789 2.34567891 3.45678912"/>' + shape + '</visual>'
    empty = '<gazebo/>'
    begin += empty * ((8192 - 30 - padding - len(begin)) // len(empty))
    client = loading.connect()
    body = loading.load_urdf(begin + visual + '</link></robot>', client, visuals=True)
    data, = pybullet.getVisualShapeData(body, physicsClientId=client)
    assert data[5] == pytest.approx((1.23456789, 2.34567891, 3.45678912))


NAMED = ('<robot name="{robot}"><link name="{link}"/><link name="b"/><joint name="{joint}" '
         'type="fixed"><parent link="{link}"/><child link="b"/></joint></robot>')


@pytest.mark.parametrize('key, kind', [
    ('robot', 'robot or model'), ('link', 'link'), ('joint', 'joint')])
def test_names_that_would_crash_pybullet(key, kind):
    longest = {'robot': 'r', 'link': 'a', 'joint': 'j', key: '\u00e4' * 250}
    client = loading.connect()
    body = loading.load_urdf(NAMED.format(**longest), client, fixed=True)
    assert pybullet.getNumJoints(body, physicsClientId=client) == 1
    longest[key] += 'x'
    assert refusal(loading.load_urdf, NAMED.format(**longest), client, fixed=True) == (
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
    """Return a URDF of one link."""
    return '<robot name="r"><link name="a">{}{}</link></robot>'.format(INERTIAL, ''.join(shapes))


def mesh(tag, path):
    return SHAPE.format(tag, '<mesh filename="{}"/>'.format(path))


def test_visual_meshes_that_cannot_be_read_are_not_seen(tmp_path):
    (tmp_path / 'a.dae').write_text('<COLLADA/>')
    visual = mesh('visual', tmp_path / 'a.dae')
    text = robot(visual, SHAPE.format('visual', '<box size="1 2 3"/>')).replace(
        '</robot>', '<link name="b">{}</link><joint name="j" type="fixed"><parent link="a"/>'
        '<child link="b"/></joint></robot>'.format(visual))
    client = loading.connect()
    body = loading.load_urdf(text, client, fixed=True, visuals=True)
    seen = [data[1:4] for data in pybullet.getVisualShapeData(body, physicsClientId=client)]
    assert seen == [(-1, pybullet.GEOM_BOX, (1, 2, 3)), (0, pybullet.GEOM_BOX, (0, 0, 0))]


def test_a_visual_obj_has_its_texture(tmp_path):
    Image.new('RGB', (2, 2), (10, 20, 30)).save(str(tmp_path / 'a.png'))
    (tmp_path / 'a.mtl').write_text('newmtl {}\nmap_Kd a.png\n'.format('m' * 5000))
    (tmp_path / 'a.obj').write_text('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\n'
                                    'vt 0 1\nusemtl {}\nf 1/1 2/2 3/3\n'.format('m' * 5000))
    client = loading.connect()
    body = loading.load_urdf(robot(mesh('visual', tmp_path / 'a.obj')), client, visuals=True)
    data, = pybullet.getVisualShapeData(body, pybullet.VISUAL_SHAPE_DATA_TEXTURE_UNIQUE_IDS,
                                        physicsClientId=client)
    assert data[8] >= 0


def test_a_damaged_mesh_is_not_given_to_pybullet(tmp_path, capfd):
    (tmp_path / 'a.stl').write_bytes(bytes(133))
    client = loading.connect()
    capfd.readouterr()
    assert refusal(loading.load_urdf, robot(mesh('collision', tmp_path / 'a.stl')), client
                   ).startswith('cannot read the mesh {}: '.format(tmp_path / 'a.stl'))
    assert capfd.readouterr() == ('', '')


@pytest.mark.parametrize('attribute', ['', ' concave="yes"'])
def test_objects_of_an_obj_are_not_joined(tmp_path, attribute):
    (tmp_path / 'a.obj').write_text(TWO_BOXES)
    text = robot(mesh('collision', tmp_path / 'a.obj'))
    client, files = loading.connect(), len(os.listdir('/proc/self/fd'))
    body = loading.load_urdf(text.replace('<collision', '<collision' + attribute), client,
                             fixed=True)
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
    with pytest.raises(SimulationError, match='cannot write to {}/file/.*: Not a directory; set '
                       'XDG_CACHE_HOME to a folder'.format(tmp_path)):
        mesh_cache.cached(str(tmp_path / 'a.obj'))
