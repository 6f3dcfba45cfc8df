"""World files: what is built of them, what is left out with a warning, what is refused."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pybullet
import pytest

from img_recog.simulation import loading, world_file
from img_recog.simulation.settings import PhysicsSettings, SimulationError
from img_recog.simulation.world import World
from img_recog_testing.robots import WORLDS

BOX = '<{0} name="s">{1}<geometry><box><size>{2}</size></box></geometry></{0}>'
INERTIAL = ('<inertial><mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.02</iyy><izz>0.02</izz>'
            '<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>')
MESH = '<visual name="v"><geometry><mesh><uri>{}</uri></mesh></geometry></visual>'
SHELF = ('<model name="shelf"><static>true</static><pose>1 2 1 0 0 0</pose><link name="l">'
         + INERTIAL + BOX.format('collision', '', '0.8 0.8 0.2') + '</link></model>')
CRATE = ('<model name="crate"><pose>{}</pose><link name="l">' + INERTIAL
         + BOX.format('collision', '', '0.2 0.2 0.2') + '</link></model>')
# a tetrahedron of 1 m at the origin
PEAK = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'
BUILT_IN = ('<include><uri>model://ground_plane</uri></include>'
            '<include><uri>model://sun</uri></include>')


def sdf(*models):
    return '<sdf version="1.6"><world name="default">{}</world></sdf>'.format(''.join(models))


@pytest.fixture
def read(tmp_path):
    """A function that writes a world file and reads it."""
    def read_text(text, name='hall.world', **more):
        path = tmp_path / name
        path.write_text(text)
        return world_file.read(str(path), WORLDS, **more)
    return read_text


def build(file):
    return World(PhysicsSettings(), file, loading.connect())


def extent(body, client):
    return [np.array(corner) for corner in pybullet.getAABB(body.body_id, physicsClientId=client)]


def test_world_by_name():
    file = world_file.read('turtlebot3_world', WORLDS)
    assert (file.name, file.sdf, file.warnings) == ('turtlebot3_world', False, ())
    body, = build(file).bodies
    assert (body.name, body.fixed) == ('turtlebot3_world', True)


def test_empty_world_is_the_floor():
    file = world_file.read('empty', WORLDS)
    assert file == ('empty', '', False, ())
    world = build(file)
    assert world.bodies == [] and world.floor.name == 'ground_plane'
    assert pybullet.getNumBodies(physicsClientId=world.physics_client_id) == 1


def test_urdf_by_path_stays_where_it_is(read):
    box = '<{0}><geometry><box size="1 1 1"/></geometry></{0}>'.format('collision')
    file = read('<robot name="hall"><link name="floating"><inertial><origin xyz="0 0 3"/>'
                '<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
                '</inertial>{}</link></robot>'.format(box), 'hall.urdf')
    assert (file.name, file.sdf, file.warnings) == ('hall', False, ())
    world = build(file)
    before = world.bodies[0].pose()
    world.step(500)
    assert world.bodies[0].pose() == before


def test_static_model_floats_and_a_crate_falls_onto_the_floor(read):
    file = read(sdf(BUILT_IN, SHELF, CRATE.format('-1 0 0.5 0 0 0.5')))
    assert (file.name, file.sdf, file.warnings) == ('hall', True, ())
    world = build(file)
    shelf, crate = world.bodies
    assert (shelf.name, crate.name) == ('shelf', 'crate')
    assert (shelf.mass(), crate.mass()) == (0.0, 2.0)
    start = crate.pose()
    assert start.position == pytest.approx((-1, 0, 0.5))
    world.step(2000)
    assert shelf.motion().position == pytest.approx([1, 2, 1], abs=1e-9)
    assert crate.motion().position == pytest.approx([-1, 0, 0.1], abs=0.002)
    assert crate.motion().linear == pytest.approx([0, 0, 0], abs=1e-3)
    world.reset()
    assert crate.pose().position == pytest.approx(start.position, abs=1e-9)
    assert crate.pose().orientation == pytest.approx(start.orientation, abs=1e-6)
    world.step()
    assert crate.motion().linear == pytest.approx([0, 0, -0.0098], abs=1e-4)


def test_static_model_carries_what_falls_on_it(read):
    world = build(read(sdf(SHELF.replace('true', '1'), CRATE.format('1 2 1.6 0 0 0'))))
    shelf, crate = world.bodies
    world.step(2000)
    assert crate.motion().position == pytest.approx([1, 2, 1.2], abs=0.005)
    assert shelf.motion().position == pytest.approx([1, 2, 1], abs=1e-9)


TURNED = '<pose>1 0 0 0 0 1.5707963267948966</pose>'       # of a model: its x is the world's y
PART = '<link name="{}"><pose>{}</pose>' + INERTIAL + BOX.format(
    'collision', '<pose>0.1 0 0 0 0 0</pose>', '0.2 0.2 0.2') + '</link>'
TIE = '<joint name="{0}_{1}" type="fixed"><parent>{0}</parent><child>{1}</child></joint>'


@pytest.mark.parametrize('inside, names, places', [
    (PART.format('a', '0 0 3 0 0 0'), ['m'], [(1, 0.1, 3)]),
    (PART.format('a', '0 2 3 0 0 3.141592653589793'), ['m'], [(-1, -0.1, 3)]),
    (PART.format('a', '1 0 3 0 0 0') + PART.format('b', '2 0 4 0 0 0'), ['m', 'm::b'],
     [(1, 1.1, 3), (1, 2.1, 4)]),
    (PART.format('b', '2 0 4 0 0 0') + PART.format('a', '1 0 3 0 0 0') + TIE.format('a', 'b'),
     ['m'], [(1, 1.1, 3), (1, 2.1, 4)])])
def test_links_are_where_their_poses_put_them(read, inside, names, places):
    world = build(read(sdf('<model name="m">', TURNED, inside, '</model>')))
    assert [body.name for body in world.bodies] == names
    corners = [pybullet.getAABB(body.body_id, link, physicsClientId=world.physics_client_id)
               for body in world.bodies for link in body.links]
    assert np.mean(corners, axis=1) == pytest.approx(np.array(places), abs=1e-3)


@pytest.mark.parametrize('static, tie, height', [
    ('true', '', 3), ('false', TIE.format('world', 'a'), 3), ('false', '', 2.951)])
def test_what_is_tied_to_the_world_does_not_fall(read, static, tie, height):
    world = build(read(sdf('<model name="m"><static>', static, '</static>',
                           PART.format('a', '0 0 3 0 0 0'), tie, '</model>')))
    world.step(100)
    assert world.bodies[0].motion().position[2] == pytest.approx(height, abs=1e-3)


def test_model_in_a_model_is_warned_of(read):
    file = read(sdf('<model name="m">', PART.format('a', '0 0 3 0 0 0'), SHELF, '</model>'))
    warning, = file.warnings
    assert warning.endswith('left out: shelf') and '\n' not in warning


@pytest.mark.parametrize('inside, words', [
    (PART.format('a', '0 0 3'), "<pose> of link a: got '0 0 3', expected 6 finite numbers"),
    (PART.format('a', '0 0 x 0 0 nan'), "got '0 0 x 0 0 nan', expected 6 finite numbers"),
    (PART.format('', ''), 'each <link> of model m must have a unique name'),
    (PART.format('a', '') * 2, 'each <link> of model m must have a unique name')])
def test_refuses_links_that_crash_pybullet_or_stand_nowhere(read, inside, words):
    with pytest.raises(SimulationError) as error:
        read(sdf('<model name="m">', inside, '</model>'))
    assert words in str(error.value) and '\n' not in str(error.value)


def test_refuses_a_urdf_with_two_roots_which_would_crash_pybullet(read):
    links = '<robot name="w"><link name="a"/><link name="b"/><link name="c"/>{}</robot>'
    joint = '<joint name="{0}" type="fixed"><parent link="a"/><child link="{0}"/></joint>'
    with pytest.raises(SimulationError) as error:
        read(links.format(joint.format('b')), 'w.urdf')
    assert 'w.urdf: got 2 root links (a, c), expected one' in str(error.value)
    assert '\n' not in str(error.value)
    assert read(links.format(joint.format('b') + joint.format('c')), 'w.urdf').name == 'w'


@pytest.mark.parametrize('uri', ['meshes/peak.obj', 'file://{}/meshes/peak.obj', 'model://peak'])
def test_mesh_beside_the_world_file_by_its_path_or_found_elsewhere(read, tmp_path, uri):
    (tmp_path / 'meshes').mkdir()
    peak = tmp_path / 'meshes' / 'peak.obj'
    peak.write_text(PEAK)
    shape = MESH.format(uri.format(tmp_path)).replace('visual', 'collision')
    file = read(sdf('<model name="peak"><static>1</static><pose>0 0 5 0 0 0</pose><link name="l">'
                    + shape + '</link></model>'),
                find_mesh={'model://peak': str(peak)}.get)
    assert file.warnings == () and str(peak) in file.text
    world = build(file)
    low, high = extent(world.bodies[0], world.physics_client_id)
    assert low == pytest.approx([0, 0, 5], abs=0.05) and high == pytest.approx([1, 1, 6], abs=0.05)


def test_missing_mesh_is_warned_of_and_its_collision_shape_is_seen(read):
    lost = SHELF.replace('</link>', MESH.format('model://shelf/a.dae') + '</link>')
    file = read(sdf(lost))
    warning, = file.warnings
    assert 'model://shelf/a.dae' in warning and '\n' not in warning
    world = build(file)
    seen, = pybullet.getVisualShapeData(world.bodies[0].body_id,
                                        physicsClientId=world.physics_client_id)
    assert seen[2] == pybullet.GEOM_BOX and seen[3] == pytest.approx((0.8, 0.8, 0.2))


def test_include_of_another_model_is_warned_of(read):
    file = read(sdf(BUILT_IN, '<include><uri> model://table </uri></include>', SHELF))
    warning, = file.warnings
    assert 'model://table' in warning and 'ground_plane' not in warning and '\n' not in warning
    assert len(build(file).bodies) == 1


@pytest.mark.parametrize('content, words', [
    (None, 'which cannot be read as a file'), (b'robot:', 'not XML'), (b'', 'not XML'),
    (b'<robot', 'not XML'), (bytes(range(256)), 'not XML'),
    (b'<?xml version="1.0" encoding="klingon"?><robot/>', 'unknown encoding'),
    (b'<a>' * 200 + b'</a>' * 200, 'nested too deeply: more than 100 levels at line 1'),
    (b'<world/>', 'whose root element is <world>, not <robot> (URDF) or <sdf>')])
def test_refusals_name_the_value_and_what_is_allowed(tmp_path, content, words):
    path = tmp_path / 'mars.world'
    if content is not None:
        path.write_bytes(content)
    for value in ([str(path)] if content is not None else [str(path), str(tmp_path), 'a\0b']):
        with pytest.raises(SimulationError) as error:
            world_file.read(value, WORLDS)
        message = str(error.value)
        assert message.startswith('world: got {!r}'.format(value)) and words in message
        assert message.endswith('allowed is turtlebot3_world, empty or the path of a URDF or SDF '
                                'file')
        assert '\n' not in message


def test_refuses_an_sdf_without_a_model(read):
    with pytest.raises(SimulationError) as error:
        build(read(sdf(BUILT_IN)))
    assert 'world hall' in str(error.value) and '\n' not in str(error.value)


def test_parts_of_a_model_have_their_own_links_and_joints_alone(read):
    links = ''.join('<link name="{}">{}</link>'.format(name, INERTIAL) for name in 'abcd')
    joints = ''.join(
        '<joint name="{0}{1}" type="revolute"><parent>{0}</parent><child>{1}</child></joint>'
        .format(*pair) for pair in ('cd', 'bc'))
    file = read(sdf('<model name="m">' + links + joints + '</model>'))
    models = ElementTree.fromstring(file.text).findall('world/model')
    assert [model.get('name') for model in models] == ['m', 'm::b']
    assert [[part.get('name') for part in model if part.get('name')] for model in models] == [
        ['a'], ['b', 'bc', 'c', 'cd', 'd']]


def test_what_is_static_has_no_mass_and_no_inertia(read):
    inertial = ElementTree.fromstring(read(sdf(SHELF)).text).findall('.//inertial')
    assert len(inertial) == 1 and inertial[0].findtext('mass') == '0'
    assert {part.tag: part.text for part in inertial[0].find('inertia')} == dict.fromkeys(
        ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), '0')
    assert len(inertial[0]) == 2
