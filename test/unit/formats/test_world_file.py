"""World files: what is built of them, what is left out with a warning, what is refused."""
import numpy as np
import pybullet
import pytest

from img_recog.formats import world_file
from img_recog.formats.world_file import WorldFile
from img_recog.report import LEFT_OUT, LIFTED, Report, lines_of
from img_recog.model import BOX, Model, Shape
from img_recog.simulation import assembly
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import WORLDS
from img_recog_helpers.sdf import BUILT_IN, CRATE, SHELF, sdf

MESH = '<visual name="v"><geometry><mesh><uri>{}</uri></mesh></geometry></visual>'
SCRIPT = ('<visual name="v"><geometry><box><size>1 1 1</size></box></geometry><material><script>'
          '<name>{}</name></script></material></visual>')
HINGE = ('<model name="m"><link name="a"/><link name="b"/><joint name="j" '
         'type="hinge"><parent>a</parent><child>b</child></joint></model>')
ADVICE = ('; set GAZEBO_MODEL_PATH to the folders of the models, or add '
          'allow_partial_world:=true to load the rest')


@pytest.fixture
def read(tmp_path):
    """A function that writes a world file and reads it."""
    def read_text(text, name='hall.world', **more):
        path = tmp_path / name
        path.write_text(text)
        return world_file.read(str(path), WORLDS, **more)
    return read_text


def build(file):
    return World(PhysicsSettings(), file, connect())


def extent(body):
    return [np.array(corner) for corner in pybullet.getAABB(
        body.body_id, physicsClientId=body.physics_client_id)]


def test_world_by_name():
    file = world_file.read('turtlebot3_world', WORLDS)
    assert (file.name, len(file.trees), file.findings) == ('turtlebot3_world', 1, ())
    body, = build(file).bodies
    assert (body.name, body.fixed) == ('turtlebot3_world', True)


def test_empty_world_is_the_floor():
    file = world_file.read('empty', WORLDS)
    assert file == WorldFile('empty', (), (0.0, 0.0, -9.8), True, None)
    world = build(file)
    assert world.scenery == [] and world.floor.name == 'ground_plane'
    assert pybullet.getNumBodies(physicsClientId=world.physics_client_id) == 1


def test_what_is_not_simulated_is_warned_of(read):
    file = read(sdf(BUILT_IN, '<plugin name="wind" filename="libwind.so"/>',
                    '<include><uri>model://none</uri></include>'), allow_partial=True)
    assert [line.split(': ', 1)[1] for line in lines_of(file.findings)] == [
        'not simulated: plugin libwind.so of world default',
        'loaded without: model://none; set GAZEBO_MODEL_PATH to the folders of the models']


def test_urdf_by_path_stays_where_it_is(read):
    box = '<{0}><geometry><box size="1 1 1"/></geometry></{0}>'.format('collision')
    file = read('<robot name="hall"><link name="floating"><inertial><origin xyz="0 0 3"/>'
                '<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
                '</inertial>{}</link></robot>'.format(box), 'hall.urdf')
    assert (file.name, file.findings) == ('hall', ())
    world = build(file)
    before = world.scenery[0].pose()
    world.step(500)
    assert world.scenery[0].pose() == before


def test_a_world_that_the_finder_finds(tmp_path):
    (tmp_path / 'hall.world').write_text(sdf(SHELF))
    found = {'worlds/hall.world': str(tmp_path / 'hall.world')}
    assert world_file.read('worlds/hall.world', WORLDS, found.get).name == 'hall'


def test_what_starts_in_the_floor_is_lifted_onto_it_at_rest(read):
    world = build(read(sdf(BUILT_IN, CRATE.format('-1 0 0 0 0 0.5'), CRATE.format(
        '2 0 -0.3 0 0 0').replace('crate', 'low'), CRATE.format(
            '4 0 0.097 0 0 0').replace('crate', 'high'),
        SHELF.replace('1 2 1 0 0 0', '1 2 0 0 0 0'))))
    assert world.report.of(LIFTED) == ['crate by 0.100 m', 'low by 0.400 m']
    heights = [body.pose().position[2] for body in world.scenery]
    assert heights == pytest.approx([0.1, 0.1, 0.097, 0.0], abs=1e-6)
    highest = 0.0
    for _ in range(200):
        world.step(5)
        highest = max(highest, *(body.pose().position[2] for body in world.scenery))
    assert highest < 0.105
    world.reset()
    assert [body.pose().position[2] for body in world.scenery] == pytest.approx(heights)


def test_refuses_a_urdf_with_two_roots_which_would_crash_pybullet(read):
    links = '<robot name="w"><link name="a"/><link name="b"/><link name="c"/>{}</robot>'
    joint = '<joint name="{0}" type="fixed"><parent link="a"/><child link="{0}"/></joint>'
    assert 'w.urdf: got 2 root links (a, c), expected one' in refusal(
        read, links.format(joint.format('b')), 'w.urdf')
    assert read(links.format(joint.format('b') + joint.format('c')), 'w.urdf').name == 'w'


@pytest.mark.parametrize('uri', ['meshes/peak.obj', 'file://{}/meshes/peak.obj', 'model://peak'])
def test_mesh_beside_the_world_file_by_its_path_or_found_elsewhere(read, tmp_path, uri):
    (tmp_path / 'meshes').mkdir()
    peak = tmp_path / 'meshes' / 'peak.obj'
    peak.write_text('')
    shape = MESH.format(uri.format(tmp_path)).replace('visual', 'collision')
    file = read(sdf('<model name="peak"><static>1</static><pose>0 0 5 0 0 0</pose><link name="l">'
                    + shape + '</link></model>'), find={'model://peak': str(peak)}.get)
    solid, = file.trees[0].model.links[0].solids
    assert file.findings == () and solid.shape.path == str(peak)


@pytest.mark.parametrize('text, name', [
    (sdf('<model name="bowl"><static>1</static><link name="l"><collision name="c"><geometry><mesh>'
         '<uri>a.obj</uri></mesh></geometry></collision></link></model>'), 'hall.world'),
    ('<robot name="bowl"><link name="l"><collision><geometry><mesh filename="a.obj"/>'
     '</geometry></collision></link></robot>', 'hall.urdf')], ids=['sdf', 'urdf'])
def test_the_mesh_of_what_never_moves_is_not_filled(read, tmp_path, text, name):
    (tmp_path / 'a.obj').write_text('')
    tree, = read(text, name).trees
    assert tree.fixed and [solid.is_concave for solid in tree.model.links[0].solids] == [True]


def test_missing_mesh_is_refused_and_by_request_its_collision_shape_is_seen(read):
    lost = sdf(SHELF.replace('</link>', MESH.format('model://shelf/a.dae') + '</link>'))
    line = refusal(read, lost)
    assert line.endswith('hall.world: not found, or not supported: mesh model://shelf/a.dae'
                         + ADVICE)
    file = read(lost, allow_partial=True)
    warning, = lines_of(file.findings)
    assert 'hall.world: loaded without: mesh model://shelf/a.dae; set GAZEBO_MODEL' in warning
    seen, = file.trees[0].model.links[0].looks
    assert seen.shape == Shape(BOX, (0.8, 0.8, 0.2))
    # for the physics, visuals would cost time and memory
    world = build(file)
    loaded, = pybullet.getVisualShapeData(world.scenery[0].body_id,
                                          physicsClientId=world.physics_client_id)
    assert loaded[3] == (0, 0, 0)


def test_all_that_is_missing_is_named(read):
    text = sdf('<include><uri>model://table</uri></include>', SHELF.replace(
        '</link>', MESH.format('a.dae') + MESH.format('b.dae') + '</link>'),
        '<actor name="walker"/>')
    assert ('not supported: model://table, actor walker, mesh a.dae, mesh b.dae' + ADVICE
            in refusal(read, text))
    assert len(read(text, allow_partial=True).trees) == 1


@pytest.mark.parametrize('inside, name, advice', [
    (HINGE, 'joint j of type hinge, which is held', ''), ('<actor name="w"/>', 'actor w', ''),
    (CRATE.format('0 0 3'),
     "<pose> of model crate: got '0 0 3', expected 6 finite numbers of at most 1e+06", ''),
    ('<include><uri>https://a/b</uri></include>',
     'https://a/b (a URL, which is not downloaded)',
     'download the models and include them by model://NAME, or '),
    (SHELF.replace('</link>', MESH.format('package://p/a.dae') + '</link>'),
     'mesh package://p/a.dae', 'build the packages and source their setup.bash, or '),
    (SHELF.replace('</link>', MESH.format('/dev/null') + '</link>'),
     'mesh /dev/null (a pipe or device, not a file)', ''),
    (SHELF.replace('</link>', MESH.format('/dev') + '</link>'),
     'mesh /dev (a folder, not a file)', '')])
def test_advice_says_what_can_help(read, inside, name, advice):
    assert refusal(read, sdf(inside)).endswith(
        'not supported: {}; {}add allow_partial_world:=true to load the rest'.format(name, advice))
    assert refusal(read, sdf(inside), option='--all').endswith('add --all to load the rest')
    lines = lines_of(read(sdf(inside), allow_partial=True).findings)
    assert any('loaded without: ' + name in line for line in lines)


@pytest.mark.parametrize('name, advice', [
    ('Shop/Plaid', '; set GAZEBO_MODEL_PATH to the folders of the models'), ('Gazebo/Plaid', '')])
def test_a_look_that_is_missing_is_a_warning(read, name, advice):
    file = read(sdf(SHELF.replace('</link>', SCRIPT.format(name) + '</link>')))
    warning, = lines_of(file.findings)
    assert warning.endswith(': not found, drawn in another color: material ' + name + advice)


def test_missing_mesh_of_a_urdf_is_refused_or_replaced(read):
    text = ('<robot name="w"><link name="a"><visual><geometry><mesh filename="a.dae"/></geometry>'
            '</visual><collision><geometry><box size="1 1 1"/></geometry></collision></link>'
            '</robot>')
    assert 'mesh a.dae' in refusal(read, text, 'w.urdf')
    file = read(text, 'w.urdf', allow_partial=True)
    assert 'loaded without: mesh a.dae' in lines_of(file.findings)[0]
    assert file.trees[0].model.links[0].looks


def test_textures_and_materials_of_a_urdf(read, tmp_path):
    (tmp_path / 'a.png').write_bytes(b'')
    text = ('<robot name="w"><link name="world"><visual><geometry><box size="1 1 1"/></geometry>'
            '<material name="m"><texture filename="{}"/></material></visual></link>'
            '<gazebo reference="world"><material>{}</material></gazebo></robot>')
    tree, = read(text.format('a.png', ''), 'w.urdf').trees
    assert tree.model.links[0].looks[0].material.texture == str(tmp_path / 'a.png')
    tree, = read(text.format('a.png', 'Gazebo/Red'), 'w.urdf').trees
    assert tree.model.links[0].looks[0].material.color == (1, 0, 0, 1)
    warning, = lines_of(read(text.format('b.png', ''), 'w.urdf').findings)
    assert warning.endswith('w.urdf: not found, drawn in another color: texture b.png')


@pytest.mark.parametrize('name, meant', [
    ('empy', 'empty'), ('Turtlebot3_word', 'turtlebot3_world')])
def test_a_name_that_is_similar_to_that_of_a_world_is_asked_for(name, meant):
    assert refusal(world_file.read, name, WORLDS).endswith('did you mean {}?'.format(meant))


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
        message = refusal(world_file.read, value, WORLDS)
        assert message.startswith('world: got {!r}'.format(value)) and words in message
        assert message.endswith('allowed is turtlebot3_world, empty or the path of a URDF or SDF '
                                'file')


def test_a_world_of_a_package_that_is_not_found():
    line = refusal(world_file.read, 'turtlebot3_house', WORLDS)
    assert line.startswith("world: got 'turtlebot3_house', and the package turtlebot3_gazebo with "
                           'its worlds is not found; build it in a workspace and source its ')
    assert refusal(world_file.read, 'turtlebot3_wrold', WORLDS).endswith(
        'did you mean turtlebot3_world?')
    assert 'turtlebot3_gazebo' not in refusal(
        world_file.read, 'turtlebot3_hose', {**WORLDS, 'turtlebot3_house': '/x/house.world'})


def test_what_pybullet_cannot_load_names_world_and_model(read, tmp_path, monkeypatch):
    file = read(sdf(SHELF))
    broken = file._replace(trees=(file.trees[0]._replace(model=Model('r', ())),))
    assert refusal(build, broken).startswith(
        'world hall: model shelf: PyBullet cannot load it as URDF (')


def test_what_cannot_be_loaded_is_left_out_by_request(read, tmp_path):
    (tmp_path / 'a.stl').write_bytes(b'')
    file = read(sdf(SHELF.replace('</link>', MESH.format('a.stl').replace('visual', 'collision')
                                  + '</link>'), CRATE.format('0 0 5 0 0 0')))
    broken = file.trees[0]._replace(name='broken', model=Model('r', ()))
    file = file._replace(trees=(broken, broken._replace(first=False), file.trees[0]._replace(
        first=False), file.trees[1]))
    report = Report()
    world = World(PhysicsSettings(), file, connect(), report)
    assert [body.name for body in world.scenery] == ['shelf', 'crate']
    # the rest of the model is one
    assert [tree.first for tree in world.trees] == [True, True]
    model, mesh = report.of(LEFT_OUT)
    assert model.startswith('model broken: PyBullet cannot load it as URDF (')
    assert mesh.startswith('cannot read the mesh {}: '.format(tmp_path / 'a.stl'))
    low, high = extent(world.scenery[0])
    assert high - low == pytest.approx([0.8, 0.8, 0.2], abs=0.05)
    built = assembly.build(PhysicsSettings(allow_partial_world=True), file, [])
    warning, = built.world.report.lines()
    assert warning.startswith('world hall: loaded without: model broken: PyBullet')
    line = refusal(assembly.build, PhysicsSettings(), file, [])
    assert line.startswith('world hall: not found, or not supported: model broken: ')
    assert line.endswith('or set allow_partial_world to load the rest')
