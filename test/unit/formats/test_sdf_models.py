"""Models of an SDF: where their links are, how they are joined, what is refused."""
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pybullet
import pytest

from img_recog import rotations
from img_recog.formats import sdf_models
from img_recog.formats.problems import Problems
from img_recog.formats.world_file import WorldFile
from img_recog.model import NO_INERTIA, Friction, Shape
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.sdf import BOX, INERTIAL, convert, load

TURNED = '<pose>1 0 0 0 0 1.5707963267948966</pose>'       # of a model: its x is the world's y
LINK = '<link name="{}"><pose>{}</pose>' + INERTIAL + BOX.format(
    'collision', '<pose>0.1 0 0 0 0 0</pose>', '0.2 0.2 0.2') + '</link>'
JOINT = ('<joint name="{0}_{1}" type="{2}"><parent>{0}</parent><child>{1}</child>{3}</joint>')
TIE = JOINT.format('{0}', '{1}', 'fixed', '')


def centers(world):
    """Return the centers of the links, in the order of the bodies."""
    return [np.mean(pybullet.getAABB(body.body_id, link,
                                     physicsClientId=world.physics_client_id), axis=0).tolist()
            for body in world.bodies for link in body.links]


@pytest.mark.parametrize('inside, names, places', [
    (LINK.format('a', '0 0 3 0 0 0'), ['m'], [(1, 0.1, 3)]),
    (LINK.format('a', '0 2 3 0 0 3.141592653589793'), ['m'], [(-1, -0.1, 3)]),
    (LINK.format('a', '1 0 3 0 0 0') + LINK.format('b', '2 0 4 0 0 0'), ['m', 'm::b'],
     [(1, 1.1, 3), (1, 2.1, 4)]),
    (LINK.format('b', '2 0 4 0 0 0') + LINK.format('a', '1 0 3 0 0 0') + TIE.format('a', 'b'),
     ['m'], [(1, 1.1, 3), (1, 2.1, 4)]),
    (LINK.format('a', '0 0 3 0 0 0') + '<model name="inner"><pose>0 1 3 0 0 1.5707963267948966'
     '</pose>' + LINK.format('a', '2 0 0 0 0 0') + LINK.format('b', '3 0 0 0 0 0')
     + TIE.format('a', 'b') + '</model>', ['m', 'm::inner::a'],
     [(1, 0.1, 3), (-2.1, 0, 3), (-3.1, 0, 3)])])
def test_links_are_where_their_poses_put_them(inside, names, places):
    world = load(TURNED, inside)
    assert [body.name for body in world.bodies] == names
    assert centers(world) == pytest.approx(np.array(places), abs=1e-3)


@pytest.mark.parametrize('pose', [
    '<pose relative_to="a">1 0 0 0 0 0</pose>', '<pose frame="a">1 0 0 0 0 0</pose>',
    '<pose relative_to="f">0 0 0 0 0 0</pose>', '<pose relative_to="__model__">0 1 3 0 0 0</pose>',
    '<pose relative_to="n::l">0 0 0 0 0 0</pose>', '<pose relative_to="m">0 1 3 0 0 0</pose>',
    '<pose relative_to=" world ">0 1 3 0 0 0</pose>', '<pose>0 1 3 0 0 0</pose>',
    '<pose relative_to="m::a">1 0 0 0 0 0</pose>', '<pose relative_to="j">0 0 3 0 0 0</pose>'])
def test_a_pose_relative_to_another_frame(pose):
    frames = ('<frame name="f" attached_to="a"><pose>1 0 0 0 0 0</pose></frame>'
              '<model name="n"><pose>0 0 3 0 0 0</pose>' + LINK.format('l', '0 1 0 0 0 0')
              + '</model><joint name="j" type="revolute"><pose>0 0 -3 0 0 0</pose>'
              '<parent>world</parent><child>n::l</child></joint>')
    trees = convert(LINK.format('a', '0 0 3 0 0 1.5707963267948966'), frames,
                    '<link name="b">' + pose + '</link>')
    place, = (tree.pose.translation for tree in trees if tree.name == 'm::b')
    assert place == pytest.approx([0, 1, 3], abs=1e-9)


@pytest.mark.parametrize('static, tie, fixed', [
    ('true', '', True), ('1', '', True), ('false', TIE.format('world', 'a'), True),
    ('false', '', False)])
def test_what_is_static_or_tied_to_the_world_is_fixed(static, tie, fixed):
    tree, = convert('<static>', static, '</static>', LINK.format('a', '0 0 3 0 0 0'), tie)
    assert tree.fixed is fixed


def turned_about(world, angle):
    """Return the place of the second link when its joint has turned."""
    body = world.bodies[0]
    pybullet.resetJointState(body.body_id, body.joints['a_b'], angle,
                             physicsClientId=world.physics_client_id)
    pybullet.performCollisionDetection(physicsClientId=world.physics_client_id)
    return centers(world)[-1]


# the box of a link is at x 0.1 in it
@pytest.mark.parametrize('version, link, joint, place', [
    # about z of the child link, at its origin
    ((1, 6), '1 0 3 0 0 0', '', (1, 0.1, 3)),
    # about z at a place in the child link
    ((1, 6), '1 0 3 0 0 0', '<pose>0.1 0 0 0 0 0</pose>', (1.1, 0, 3)),
    ((1, 6), '1 0 3 0 0 0', '<axis><xyz>0 1 0</xyz></axis>', (1, 0, 2.9)),
    # the link lies on its side: its y is the model's z
    ((1, 6), '1 0 3 1.5707963267948966 0 0', '<axis><xyz>0 1 0</xyz></axis>', (1, 0.1, 3)),
    ((1, 6), '1 0 3 1.5707963267948966 0 0',
     '<axis><xyz>0 0 1</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>',
     (1, 0.1, 3)),
    ((1, 10), '1 0 3 1.5707963267948966 0 0',
     '<axis><xyz expressed_in="__model__">0 0 1</xyz></axis>', (1, 0.1, 3)),
    ((1, 10), '1 0 3 1.5707963267948966 0 0', '<axis><xyz>0 1 0</xyz></axis>', (1, 0.1, 3)),
    ((1, 5), '1 0 3 1.5707963267948966 0 0', '<axis><xyz>0 1 0</xyz></axis>', (1, 0.1, 3)),
    ((1, 10), '1 0 3 1.5707963267948966 0 0', '<axis><xyz expressed_in="">0 1 0</xyz></axis>',
     (1, 0.1, 3)),
    ((1, 10), '1 0 3 0 0 0', '<axis><xyz expressed_in="f">0 1 0</xyz></axis>', (1, 0.1, 3)),
    ((1, 4), '1 0 3 1.5707963267948966 0 0', '<axis><xyz>0 1 0</xyz>'
     '<use_parent_model_frame> False </use_parent_model_frame></axis>', (1, 0.1, 3)),
    ((1, 6), '1 0 3 0 0 0', '<axis/>', (1, 0.1, 3)),
    ((1, 4), '1 0 3 1.5707963267948966 0 0', '<axis><xyz>0 0 1</xyz></axis>', (1, 0.1, 3))])
def test_a_joint_turns_about_its_axis(version, link, joint, place):
    frame = '<frame name="f"><pose>0 0 0 1.5707963267948966 0 0</pose></frame>'
    world = load(frame, LINK.format('a', '0 0 3 0 0 0'), LINK.format('b', link),
                 JOINT.format('a', 'b', 'revolute', joint), version=version)
    assert turned_about(world, math.pi / 2) == pytest.approx(place, abs=2e-3)


@pytest.mark.parametrize('kind, axis, expected', [
    ('revolute', '', ('continuous', None)),
    ('revolute', '<limit><lower>-1e16</lower><upper>1e16</upper></limit>', ('continuous', None)),
    ('revolute', '<limit><lower>-0.5</lower><upper>1.5</upper></limit>',
     ('revolute', (-0.5, 1.5))),
    ('prismatic', '<limit><lower>0</lower><upper>2</upper></limit>',
     ('prismatic', (0.0, 2.0))),
    ('revolute', '<limit><lower>-0.5</lower></limit>', ('revolute', (-0.5, 1e16))),
    ('revolute', '<limit><upper>1.5</upper></limit>', ('revolute', (-1e16, 1.5))),
    ('revolute', '<limit><lower>0.5</lower><upper>-0.5</upper></limit>', ('continuous', None)),
    ('revolute', '<limit/>', ('continuous', None)),
    ('revolute', '<limit><lower> -Inf </lower><upper>Infinity</upper></limit>',
     ('continuous', None)),
    ('prismatic', '<limit><lower>-1</lower><upper>+inf</upper></limit>',
     ('prismatic', (-1, 1e16))),
    ('prismatic', '', ('prismatic', (-1e16, 1e16))),
    ('continuous', '<limit><lower>0</lower><upper>2</upper></limit>', ('continuous', None))])
def test_limits_of_joints(kind, axis, expected):
    tree, = convert(LINK.format('a', ''), LINK.format('b', ''),
                    JOINT.format('a', 'b', kind, '<axis><xyz>0 2 1</xyz>' + axis + '</axis>'))
    joint, = tree.model.joints
    assert joint.axis * 5 ** 0.5 == pytest.approx([0, 2, 1])
    limits = joint.limits
    assert (joint.kind, limits and limits[:2]) == expected
    assert limits is None or (limits.effort, limits.velocity) == (1e9, 1e9)


def test_trees_have_their_own_links_and_joints_alone():
    links = ''.join(LINK.format(name, '') for name in 'abcd')
    joints = ''.join(JOINT.format(*pair, 'revolute', '') for pair in ('cd', 'bc'))
    trees = convert(links, joints)
    assert [tree.name for tree in trees] == ['m', 'm::b']
    parts = [[part.name for part in tree.model.links + tree.model.joints] for tree in trees]
    assert parts == [['a'], ['b', 'c', 'd', 'b_c', 'c_d']]


def test_a_link_without_an_inertia_has_that_of_sdf():
    tree, = convert('<link name="a">' + BOX.format('collision', '', '1 1 1') + '</link>')
    inertia = tree.model.links[0].inertia
    assert inertia.mass == 1 and inertia.matrix.tolist() == np.eye(3).tolist()


def test_what_is_static_has_no_mass_and_no_inertia():
    tree, = convert('<static>1</static>', LINK.format('a', ''))
    assert [link.inertia for link in tree.model.links] == [NO_INERTIA]


TWO = LINK.format('a', '') + LINK.format('b', '')
FRICTION = LINK.format('a', '').replace('<geometry>', '<surface><friction><ode>{}</ode></friction>'
                                        '</surface><geometry>')


@pytest.mark.parametrize('inside, problem, links', [
    (TWO.replace('<pose>', '<pose>x ', 1), "<pose> of link a: got 'x', expected 6 finite numbers",
     ['b']),
    (TWO + TIE.format('a', 'c'), 'joint a_c has the link c, which does not exist', ['a', 'b']),
    (TWO + JOINT.format('a', 'b', 'revolute', '<axis><xyz>0 0 0</xyz></axis>'),
     '<xyz> of joint a_b: got 0 0 0, expected a direction', ['a', 'b']),
    (TWO + JOINT.format('a', 'b', 'revolute', '<axis><limit><upper>x</upper></limit></axis>'),
     "<upper> of joint a_b: got 'x', expected 1 finite number", ['a', 'b']),
    (TWO + JOINT.format('a', 'b', 'hinge', ''), 'joint a_b of type hinge, which is held', ['a b']),
    (TWO + '<link name="c"><pose relative_to="c"/></link>',
     'model m: the pose of c depends on itself', ['a', 'b']),
    (TWO + '<link name="c"><pose relative_to="f"/></link><frame name="f" attached_to="g"/>'
     '<frame name="g" attached_to="f"/>', 'model m: the pose of f depends on itself',
     ['a', 'b']),
    (TWO + '<model name="n"><pose>1</pose>' + LINK.format('c', '') + '</model>',
     "<pose> of model n: got '1', expected 6 finite numbers", ['a', 'b']),
    (TWO.replace('<mass>2', '<mass>0', 1), '<mass> of link a: got 0 kg, expected more than 0',
     ['a', 'b']),
    (TWO.replace('<mass>2', '<mass>1e300', 1),
     '<mass> of link a: got 1e+300 kg, expected at most 1e+09', ['a', 'b']),
    (TWO.replace('<izz>0.02', '<izz>1e16', 1),
     'link a: got the moment of inertia 1e+16 kg m2, expected at most 1e+15', ['a', 'b']),
    (TWO.replace('<ixx>0.02', '<ixx>x', 1), "<ixx> of link a: got 'x', expected 1 finite number",
     ['a', 'b']),
    (TWO.replace('<size>0.2', '<size>', 1),
     "<size> of collision s: got ' 0.2 0.2', expected 3 finite numbers", ['a', 'b']),
    (TWO.replace('box>', 'cone>', 2), '<cone> of collision s', ['a', 'b']),
    (FRICTION.format('<mu>much</mu>'), "<mu> of link a: got 'much', expected 1 finite number",
     ['a'])])
def test_only_what_cannot_be_used_is_left_out(inside, problem, links):
    trees = convert(inside, problems=[problem])
    assert [' '.join(link.name for link in tree.model.links) for tree in trees] == links
    world = World(PhysicsSettings(), WorldFile('w', tuple(trees)), connect())
    assert len(world.bodies) == len(links) and all(
        body.mass() >= 1 for body in world.bodies)


def test_a_model_without_a_link_is_nothing():
    assert convert('<static>1</static>') == []


def test_what_trees_say_of_themselves():
    inner = ('<model name="n"><pose>1 2 3 0 0 1.5707963267948966</pose>'
             + LINK.format('l', '0.1 0.2 0.3 0 0 0.5') + '</model>')
    first, second = convert('<pose>10 0 0 0 0 3.141592653589793</pose>',
                            '<link><inertial><inertia><ixx>9</ixx></inertia></inertial></link>',
                            inner)
    assert (first.name, first.first, first.fixed, first.model.terrain) == ('m', True, False, None)
    assert (second.name, second.first, second.model.terrain) == ('m::n::l', False, None)
    warning, = first.model.warnings
    assert warning.startswith('link : got the principal moments of inertia 1, 1, 9 kg m2; ')
    assert second.model.warnings == ()
    assert first.model.links[0].name == 'link'
    assert second.in_model.translation == pytest.approx((0.8, 2.1, 3.3))
    assert rotations.to_rpy(second.in_model.rotation) == pytest.approx((0, 0, 0.5 + math.pi / 2))
    assert second.pose.translation == pytest.approx((9.2, -2.1, 3.3))


@pytest.mark.parametrize('inside, root', [
    (LINK.format('a', '') + '<model name="n"><static>1</static>' + LINK.format('l', '')
     + '</model>' + TIE.format('a', 'n::l'), 'n::l'),
    (LINK.format('a', '') + LINK.format('b', '') + TIE.format('a', 'b')
     + TIE.format('world', 'b'), 'b'),
    (LINK.format('a', '') + LINK.format('b', '') + LINK.format('c', '') + TIE.format('b', 'a')
     + TIE.format('c', 'b'), 'c'),
    (LINK.format('a', '') + LINK.format('b', '') + LINK.format('c', '') + TIE.format('b', 'a')
     + TIE.format('b', 'c'), 'b')])
def test_the_root_of_joined_links(inside, root):
    tree, = convert(inside)
    assert tree.model.root == tree.model.links[0].name == root and tree.model.name == 'm'


def test_a_shape_that_is_lost_is_replaced_by_the_others():
    box = LINK.format('a', '').replace('</link>', BOX.format(
        'visual', '<pose>1 2 3 0 0 0</pose>', '4 5 6').replace('name="s"', 'name="v"') + '</link>')
    for lost, kept in (('collision', 'visual'), ('visual', 'collision')):
        broken = '<{0} name="x"><geometry><cone/></geometry></{0}>'.format(lost)
        text = box.replace('<' + lost, '<other').replace('</' + lost, '</other').replace(
            '</link>', broken + '</link>')
        tree, = convert(text, problems=['<cone> of {} x'.format(lost)])
        link, = tree.model.links
        size = {'visual': (4, 5, 6), 'collision': (0.2, 0.2, 0.2)}[kept]
        assert [each.shape for each in (*link.looks, *link.solids)] == [Shape('box', size)] * 2


@pytest.mark.parametrize('static, inside, concave', [
    ('0', '', False), ('1', '', True), ('0', TIE.format('world', 'a'), True)])
def test_meshes_of_what_does_not_move_are_concave(tmp_path, static, inside, concave):
    (tmp_path / 'a.stl').write_text('')
    model = ElementTree.fromstring(
        '<model name="m"><static>{}</static><link name="a"><collision name="c"><geometry><mesh>'
        '<uri>a</uri></mesh></geometry></collision></link>{}</model>'.format(static, inside))
    tree, = sdf_models.trees(model, (1, 6), lambda uri: str(tmp_path / 'a.stl'), Problems())
    solid, = tree.model.links[0].solids
    assert solid.is_concave is concave


def test_a_pose_of_a_joint_or_frame_that_is_relative_to_another():
    tree, = convert(
        LINK.format('a', '0 0 1 0 0 0'), LINK.format('b', '0 2 0 0 0 0'),
        '<frame name="f" attached_to="b"><pose relative_to="a">3 0 0 0 0 0</pose></frame>',
        JOINT.format('a', 'b', 'revolute', '<pose relative_to="f">0 0 5 0 0 0</pose>'))
    assert tree.model.joints[0].pose.translation == pytest.approx((3, 0, 5))


def test_a_frame_that_is_attached_to_a_joint_without_a_child():
    trees = convert('<joint name="j" type="fixed"><parent>world</parent>'
                    '<pose>1 0 0 0 0 0</pose></joint><frame name="f" attached_to="j">'
                    '<pose>0 1 0 0 0 0</pose></frame><link name="a"><pose relative_to="f">'
                    '0 0 1 0 0 0</pose></link>',
                    problems=['joint j has the link , which does not exist'])
    assert trees[0].pose.translation == pytest.approx((1, 1, 1))


@pytest.mark.parametrize('surface, friction', [
    ('', (1.0, 1.0)), ('<mu>0.25</mu>', (0.25, 1.0)), ('<mu2>0.25</mu2>', (1.0, 0.25)),
    ('<mu>5</mu><mu2>50</mu2>', (5.0, 50.0)), ('<mu>-1</mu><mu2>0</mu2>', (100.0, 0.0)),
    ('<mu>1</mu><mu2>1</mu2><fdir1>2 0 0</fdir1>', (1.0, 1.0, (0.0, 2.0, 0.0)))])
def test_friction_is_that_of_the_collision_with_gazebos_defaults(surface, friction):
    turned = FRICTION.format(surface).replace('<pose>0.1 0 0 0 0 0</pose>',
                                              '<pose>0 0 0 0 0 1.5707963267948966</pose>')
    (first, *others), = ([solid.surface for solid in tree.model.links[0].solids]
                         for tree in convert(turned))
    assert (first.mu, first.across, *([first.direction] if first.direction else ())) == friction
    assert others == [Friction()] * len(others)
