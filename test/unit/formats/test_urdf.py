"""Shapes and materials of a URDF: what is read of them, and what is refused."""
import numpy as np
import pytest

from img_recog.model import BOX, CAPSULE, CYLINDER, MESH, SPHERE, Look, Material, Shape
from img_recog.simulation.robot_spec import read_robot
from img_recog_helpers.parsed import given, lumped
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, burger

VISUAL = '<visual><geometry><box size="1 1 1"/></geometry>{}</visual>'
ROBOT = ('<robot name="r"><link name="a">' + VISUAL.format('<material name="mine"/>')
         + VISUAL.format('') + '</link><link name="b">' + VISUAL.format('') + '</link>{}</robot>')
SCAN = '<link name="base_scan">'
TAG = '<gazebo reference="{}">{}</gazebo>'
BLUE, PLAID = (TAG.format('{}', '<material>Gazebo/' + name + '</material>')
               for name in ('Blue', 'Plaid'))
DIFFUSE = '<visual><material><diffuse>0.5 0.25 0 1</diffuse></material></visual>'


def colors(*tags, find=lambda uri: None):
    """Return the color of each visual of each link, None without a material; and what is missing.
    """
    robot = given(ROBOT.format(''.join(tags)), find)
    return {link.name: [look.material and look.material.color for look in link.looks]
            for link in robot.links}, list(robot.missing_looks)


PURE, BROWN = (0, 0, 1, 1), (0.5, 0.25, 0, 1)
LAST = TAG.format('a', DIFFUSE + '<visual/><material>Gazebo/Blue</material>')


@pytest.mark.parametrize('tags, of_a, of_b, missing', [
    (BLUE.format('a'), PURE, None, []), (BLUE.format('c'), None, None, []),
    (TAG.format('a', '<mu1>1</mu1>'), None, None, []),
    (BLUE.replace(' reference="{}"', ''), None, None, []),
    (TAG.format('b', DIFFUSE), None, BROWN, []),
    (TAG.format('b', DIFFUSE) + BLUE.format('b'), None, PURE, []),
    (PLAID.format('a') + PLAID.format('b'), None, None, ['material Gazebo/Plaid']),
    (LAST, PURE, None, []), (TAG.format('c', '') + LAST, PURE, None, []),
    (PLAID.format('b') + LAST, PURE, None, ['material Gazebo/Plaid'])])
def test_a_material_of_gazebo_is_that_of_all_visuals_of_its_link(tags, of_a, of_b, missing):
    assert colors(tags) == ({'a': [of_a] * 2, 'b': [of_b]}, missing)


def test_an_unknown_material_is_a_warning():
    tag = PLAID.format('base_link')
    found = read_robot(burger('').replace('</robot>', tag + '</robot>'), 0.001,
                       lambda uri: None, 'robot.urdf')
    assert found.warnings == (
        'robot.urdf: not known or not found, of its materials: material Gazebo/Plaid; those links '
        'keep their other color',)


@pytest.mark.parametrize('link', ['base_link', 'base_scan'])
def test_links_that_are_lumped_keep_the_material(link):
    text = burger('').replace('</robot>', BLUE.format(link) + '</robot>')
    looks = [look for each in lumped(text).links for look in each.looks]
    count = text.split('<link name="{}">'.format(link))[1].split('</link>')[0].count('<visual>')
    assert [look.material and look.material.color for look in looks].count(PURE) == count > 0
    assert len(looks) == text.count('<visual>')


def test_textures_of_the_urdf_are_found_or_named():
    text = ROBOT.format('').replace('<material name="mine"/>', '<material name="m"><color rgba="1 '
                                    '1 1 1"/><texture filename="package://p/a.png"/></material>')
    for found, path, missing in ((None, '', ('texture package://p/a.png',)),
                                 ('/p/a.png', '/p/a.png', ())):
        robot = given(text, lambda uri: found)
        assert robot.missing_looks == missing
        assert robot.links[0].looks[0].material == Material((1, 1, 1, 1), path)


def robot(inside):
    return burger().replace(SCAN, SCAN + inside)


def read(inside):
    read_robot(robot(inside), 0.001, lambda uri: '/a.stl', 'robot.urdf')


@pytest.mark.parametrize('tag', ['visual', 'collision'])
@pytest.mark.parametrize('shape, words', [
    ('<box size="nan 1 1"/>', "size of box: got 'nan 1 1', expected 3 finite numbers"),
    ('<box size="1 1e300 1"/>', "size of box: got '1 1e300 1', expected numbers from -1e+06 to"),
    ('<box size="1 1"/>', "size of box: got '1 1', expected 3"),
    ('<box size="1 -1 1"/>', 'size of box: got 1 -1 1, expected no negative number'),
    ('<sphere radius="inf"/>', "radius of sphere: got 'inf', expected 1 finite number"),
    ('<cylinder radius="1"/>', 'length of cylinder: got None, expected 1 finite number'),
    ('<cylinder radius="1" length="-2"/>', 'size of cylinder: got 1 -2, expected no negative'),
    ('<capsule length="1"/>', 'radius of capsule: got None, expected 1 finite number'),
    ('<capsule radius="1"/>', 'length of capsule: got None, expected 1 finite number'),
    ('<mesh filename="a.stl" scale="1 1 1e7"/>', "scale of mesh: got '1 1 1e7', expected")])
def test_a_size_that_cannot_be_used_is_refused(tag, shape, words):
    assert refusal(read, '<{0}><geometry>{1}</geometry></{0}>'.format(tag, shape)).startswith(
        'cannot use the robot in robot.urdf: link base_scan, <{}>: {}'.format(tag, words))


@pytest.mark.parametrize('tag', ['visual', 'collision'])
@pytest.mark.parametrize('value', ['nan', '1e300', 'x', '-2e6'])
def test_a_place_that_cannot_be_used_is_refused(tag, value):
    shape = '<geometry><sphere radius="1"/></geometry>'
    assert "<origin> in <{} here>: got '0 {} 0', expected".format(tag, value) in refusal(
        read, '<{0} name="here"><origin xyz="0 {1} 0"/>{2}</{0}>'.format(tag, value, shape))


def test_sizes_of_zero_and_mirrored_meshes_are_allowed(tmp_path):
    (tmp_path / 'a.obj').write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n')
    shapes = ('<box size="0 1 1"/>', '<sphere radius="0"/>', '<cylinder radius="0" length="0"/>',
              '<mesh filename="{}" scale="-1 1 1"/>'.format(tmp_path / 'a.obj'))
    visuals = ''.join('<visual><geometry>{}</geometry></visual>'.format(each) for each in shapes)
    assert assemble(urdf=robot(visuals), find_mesh=lambda uri: uri).warnings == ()


def only_look(geometry, inside='', more='', attributes='', find=lambda uri: '/' + uri):
    """Return the look of a robot whose second link has one."""
    robot = given(
        '<robot name="r"><link name="a"/><link name="b"><visual{}><origin xyz="1 2 3" '
        'rpy="0 0 1.5707963267948966"/><geometry>{}</geometry>{}</visual></link>{}</robot>'.format(
            attributes, geometry, inside, more), find)
    look, = robot.links[1].looks
    return look


@pytest.mark.parametrize('geometry, shape', [
    ('<box size="1 2 3"/>', Shape(BOX, (1, 2, 3))),
    ('<cylinder radius="0.5" length="2"/>', Shape(CYLINDER, (0.5, 2))),
    ('<sphere radius="0.5"/>', Shape(SPHERE, (0.5,))),
    ('<mesh filename="a.stl" scale="1 2 3"/>', Shape(MESH, (1, 2, 3), '/a.stl'))])
def test_shapes_are_read(geometry, shape):
    look = only_look(geometry)
    assert look == Look(shape, look.pose)
    assert look.pose.matrix() == pytest.approx(np.array(
        [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]))


MESH_OF_FILE = '<mesh filename="a.stl"/>'


@pytest.mark.parametrize('geometry, prefers_file', [(MESH_OF_FILE, True),
                                                    ('<sphere radius="1"/>', False)])
def test_materials_are_read(geometry, prefers_file):
    color = '<color rgba="0.1 0.2 0.3 0.4"/>'
    plain = Material((0.1, 0.2, 0.3, 0.4))
    visual = only_look(geometry, '<material name="m">' + color + '</material>')
    assert (visual.material, visual.prefers_file) == (plain, prefers_file)
    named = only_look(geometry, '<material name="m"/>', '<material name="n"/><material name="m">'
                      + color + '</material>')
    assert (named.material, named.prefers_file) == (plain, prefers_file)
    texture = only_look(geometry, '<material name="m"><texture filename="a.png"/></material>')
    assert texture.material == Material((1, 1, 1, 1), '/a.png')
    empty = only_look(geometry, '<material name="m"><texture filename=""/></material>',
                      find=lambda uri: '/' + uri if uri else None)
    assert empty.material is None
    blue = only_look(geometry, '<material name="m">' + color + '</material>', BLUE.format('b'))
    assert (blue.material.color, blue.prefers_file) == ((0, 0, 1, 1), False)


def test_shapes_that_cannot_be_drawn_are_named():
    words = 'link b, <visual>: got the geometry {}, expected box, cylinder, sphere or mesh'
    assert refusal(only_look, '<capsule radius="1" length="2"/>') == words.format('capsule')
    assert refusal(only_look, '<plane/>') == words.format('plane')
    assert refusal(only_look, '', attributes=' name="v"') == '<visual v> has no geometry'
    assert refusal(given, ROBOT.format('').replace('1 1 1', '1 -1 1')).startswith(
        'link a, <visual>: size of box: got 1 -1 1')
    capsule = '<collision><geometry><capsule radius="1" length="2"/></geometry></collision>'
    lost = '<visual><geometry><mesh filename="a.stl"/></geometry></visual>'
    text = '<robot><link name="a">{}{}</link></robot>'
    assert refusal(given, text.format(capsule, lost)) == words.replace('b,', 'a,').format(
        'capsule')
    link, = given(text.format(capsule, '')).links
    assert [solid.shape for solid in link.solids] == [Shape(CAPSULE, (1, 2))]


def test_each_missing_texture_is_named_once():
    texture = '<texture filename="{}"/>'
    robot = given(ROBOT.format('<material>{0}</material><material>{0}</material>'
                               '<material>{1}</material>'.format(
                                   texture.format('a'), texture.format('b'))))
    assert robot.missing_looks == ('texture a', 'texture b')
