"""URDF in, a lumped robot out: nothing lost, and what cannot be simulated refused."""
import dataclasses
import math

import numpy as np
import pytest

from img_recog import rotations
from img_recog.formats import inertias, urdf
from img_recog.model import BOX, Joint, Shape
from img_recog_helpers.parsed import lumped
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger

ROBOT = '<robot name="r">{}</robot>'
GROUND = '<collision>{}<geometry><box size="1 1 1"/></geometry></collision>'
MASS = ('<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        '</inertial>')


def link(name, mass=1.0, inside=''):
    return '<link name="{}">{}{}</link>'.format(name, MASS.format(mass) if mass else '', inside)


def joint(name, parent, child, kind='fixed', origin=''):
    return '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>{}</joint>'.format(
        name, kind, parent, child, origin)


def test_burger_keeps_its_mass_shapes_and_frames_in_four_links():
    found = lumped(burger())
    assert found.root == 'base_footprint' and {each.name for each in found.links} == {
        'base_footprint', 'wheel_left_link', 'wheel_right_link', 'caster_back_link'}
    assert sum(each.inertia.mass for each in found.links) == pytest.approx(1.0017329, abs=1e-7)
    assert sum(len(each.looks) for each in found.links) == burger().count('<visual>') > 50
    assert sum(len(each.solids) for each in found.links) == burger().count('<collision>') > 0
    scan = found.frames['base_scan']
    assert scan.link == 'base_footprint'
    assert scan.pose.translation == pytest.approx([-0.032, 0, 0.182])
    assert found.frames['imu_link'].pose.translation == pytest.approx([-0.032, 0, 0.078])


def friction(text):
    """Return the friction of the links of a robot that have solids."""
    return {each.name: each.surface.mu for each in lumped(text).links if each.solids}


def test_friction_is_that_of_gazebos_tag_or_pybullets():
    assert friction(burger()) == {
        'base_footprint': 1.0, 'wheel_left_link': 0.1, 'wheel_right_link': 0.1,
        'caster_back_link': 0.1}
    contact = GROUND.format('') + '<contact><lateral_friction value="0.3"/></contact>'
    tag = '<gazebo reference="a"><mu1>0.7</mu1></gazebo>'
    assert friction(ROBOT.format(link('a', inside=contact))) == {'a': 0.3}
    assert friction(ROBOT.format(link('a', inside=contact) + tag)) == {'a': 0.7}
    nested = GROUND.format('<surface><friction><ode><mu>0.5</mu></ode></friction></surface>')
    tag = '<gazebo reference="a">{}</gazebo>'.format(nested)
    assert friction(ROBOT.format(link('a', inside=contact) + tag)) == {'a': 0.5}
    tag = '<gazebo reference="a">{}<mu1 value="0.6"/></gazebo>'.format(nested)
    assert friction(ROBOT.format(link('a', inside=contact) + tag)) == {'a': 0.6}


def test_chain_of_fixed_links_becomes_one_and_what_moves_stays():
    turned = '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>'
    robot = lumped(ROBOT.format(
        link('a', 0) + link('b') + link('c') + link('wheel')
        + joint('ab', 'a', 'b', origin=turned) + joint('bc', 'b', 'c', origin=turned)
        + joint('cw', 'c', 'wheel', 'continuous', '<origin xyz="1 0 0"/>')))
    moving, = robot.joints
    assert moving.parent == 'a'
    # a -> b: 1 forward, quarter turn; b -> c: 1 along b's x, which is a's y; c's x is a's -x
    assert np.allclose(moving.pose.translation, [0, 1, 0])
    assert np.allclose(robot.frames['c'].pose.translation, [1, 1, 0])


PAIR = link('a') + link('b')


@pytest.mark.parametrize('inside, words', [
    ('', 'got 0 root links (none), expected one'),
    ('<cart/><material name="m"/>', 'got 0 root links (none), expected one; its elements are '
     '<cart>, <material>; xacro expands macros only with the prefix xacro:'),
    (PAIR, '2 root links (a, b)'),
    (PAIR + joint('j', 'a', 'b') + joint('k', 'b', 'a'),
     'link a is its own ancestor, through joint k'),
    (link('r') + PAIR + joint('j', 'a', 'b') + joint('k', 'b', 'a'), 'link a is its own ancestor'),
    ('<link/>' + link('a'), 'each <link> must have a unique name'),
    (PAIR + link('c') + joint('j', 'a', 'b') + joint('j', 'a', 'c'),
     'each <joint> must have a unique name (names: j, j)'),
    (link('x') + PAIR + joint('i', 'a', 'x') + joint('j', 'a', 'b') + joint('k', 'b', 'a'),
     'link a is its own ancestor, through joint k'),
    (link('a') + link('a'), 'each <link> must have a unique name'),
    (PAIR + link('c') + joint('j', 'a', 'c') + joint('k', 'b', 'c'),
     'link c is the child of two joints, j and k'),
    (link('a') + joint('j', 'a', 'b'), 'child link b, which does not'),
    (link('a', '0'), 'link a can move but has no mass'),
    (link('a', -1), 'mass of link a: got -1 kg'),
    (link('a', '1e300'),
     'mass of link a: got 1e+300 kg, expected at most 1e+09 (or no <inertial>)'),
    (link('a', 'nan'), "mass of link a: got 'nan'"),
    (link('a', 'heavy'), "mass of link a: got 'heavy'"),
    (PAIR + joint('j', 'a', 'b', 'planar'),
     'joint j is of type planar; supported are continuous, fixed'),
    (PAIR + joint('j', 'a', 'b', 'continuous', '<axis xyz="0 0 0"/>'),
     'axis of joint j: got 0 0 0'),
    (link('a').replace('ixx="1"', 'ixx="1e16"'), 'expected at most 1e+15'),
    (link('a', inside='<contact><lateral_friction value="-0.5"/></contact>'),
     'lateral_friction of link a: got -0.5, expected at least 0'),
    (PAIR + joint('j', 'a', 'b', origin='<origin xyz="inf 0 0"/>'),
     "<origin> in <joint j>: got 'inf 0 0'"),
    (PAIR + joint('j', 'a', 'b', origin='<origin xyz="1 2"/>'), 'expected 3 finite numbers'),
    (link('a') + '<joint name="j" type="fixed"><child link="a"/></joint>',
     'joint j has the parent link None, which does not exist (links: a)'),
    (link('a') + '<joint name="j" type="fixed"><parent link="a"/></joint>',
     'joint j has the child link None, which does not exist (links: a)'),
    ('<link name="a"><inertial><mass value="1"/></inertial></link>',
     'link a: <inertial> must have <mass> and <inertia>'),
    ('<link name="a"><inertial><inertia/></inertial></link>',
     'link a: <inertial> must have <mass> and <inertia>'),
    (link('a', inside='<contact><lateral_friction/></contact>'),
     'lateral_friction of link a: got None, expected 1 finite number'),
    (link('a') + '<gazebo reference="a"><mu1>1 2</mu1></gazebo>',
     "<mu1> of link a: got '1 2', expected 1 finite number")])
def test_refusals_name_what_is_wrong_in_one_line(inside, words):
    assert words in refusal(lumped, ROBOT.format(inside))


def test_what_is_not_a_urdf():
    assert 'not XML' in refusal(lumped, '<robot')
    for tag in ('sdf', 'a'):
        assert 'root element <{}>'.format(tag) in refusal(lumped, '<{}/>'.format(tag))


def test_lumped_link_has_the_sum_of_masses_and_inertias():
    inertial = ('<inertial><origin xyz="{}"/><mass value="{}"/><inertia ixx="3" ixy="0.1" '
                'ixz="0.2" iyy="4" iyz="0.3" izz="5"/></inertial>')
    found = lumped(ROBOT.format(
        link('a', 0, inertial.format('1 0 0', 2)) + link('b', 0, inertial.format('0 0 0', 6))
        + joint('ab', 'a', 'b', origin='<origin xyz="0 0 4"/>')))
    (mass, pose, matrix), = (each.inertia for each in found.links)
    numbers = dict(zip(inertias.INERTIA_KEYS, matrix.flat))
    # 2 kg at (1, 0, 0) and 6 kg at (0, 0, 4): their center is (0.25, 0, 3)
    assert (mass, pose.translation.tolist()) == (8.0, [0.25, 0.0, 3.0])
    assert pose.rotation.tolist() == np.eye(3).tolist()
    assert matrix == pytest.approx(matrix.T)
    assert numbers == pytest.approx({
        'ixx': 6 + 2 * 9 + 6, 'ixy': 0.2, 'ixz': 0.4 + 2 * 0.75 * 3 + 6 * 0.25 * 1,
        'iyy': 8 + 2 * (0.5625 + 9) + 6 * (0.0625 + 1), 'iyz': 0.6,
        'izz': 10 + 2 * 0.5625 + 6 * 0.0625})


def test_shapes_move_with_their_link_and_keep_their_parts():
    shapes = ('<visual name="v"><origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><geometry>'
              '<box size="1 2 3"/></geometry></visual>' + GROUND.format(''))
    lump, = lumped(ROBOT.format(link('a', inside=shapes) + link('b', inside=shapes) + joint(
        'ab', 'a', 'b', origin='<origin xyz="1 2 3"/>'))).links
    assert [look.pose.translation.tolist() for look in lump.looks] == [[0, 0, 1], [1, 2, 4]]
    for look in lump.looks:
        assert rotations.to_rpy(look.pose.rotation) == pytest.approx([0.1, 0.2, 0.3])
    assert [solid.pose.translation.tolist() for solid in lump.solids] == [[0, 0, 0], [1, 2, 3]]
    assert {look.shape for look in lump.looks} == {Shape(BOX, (1, 2, 3))}
    assert {solid.shape for solid in lump.solids} == {Shape(BOX, (1, 1, 1))}


SHAPE = GROUND.format('<origin xyz="0 0 0.5"/>')


def surface(friction):
    return SHAPE + '<contact><lateral_friction value="{}"/></contact>'.format(friction)


def test_fixed_shapes_keep_their_friction_and_their_link_gives_its_mass_away():
    found = lumped(ROBOT.format(
        link('a', 0) + link('b', 2, surface(0.7)) + link('c', 0, surface(0)) + link('d', 1, SHAPE)
        + link('e', 0, surface(0)) + link('f', '0', surface(1)) + joint('ab', 'a', 'b')
        + ''.join(joint('b' + name, 'b', name, origin='<origin xyz="0 0 2"/><axis xyz="0 0 0"/>')
                  for name in 'cdef')))
    assert {each.name: each.surface.mu for each in found.links} == {'a': 0.7, 'c': 0.0, 'd': 1.0}
    assert {each.name: [solid.pose.translation[2] for solid in each.solids]
            for each in found.links} == {'a': [0.5], 'c': [2.5, 2.5], 'd': [2.5, 2.5]}
    assert {each.name: each.inertia.mass for each in found.links} == {'a': 3.0, 'c': 0.0, 'd': 0.0}
    assert found.joints == (
        Joint('c/joint', 'fixed', 'a', 'c'), Joint('d/joint', 'fixed', 'a', 'd'))
    assert {frame.link for frame in found.frames.values()} == {'a'}
    assert list(found.frames['e'].pose.translation) == [0, 0, 2]
    assert found.missing_meshes == () and found.warnings == () and found.name == 'r'
    assert lumped('<robot>' + link('a') + '</robot>').name == 'robot'


SLIPPERY = SHAPE.replace(
    '</c', '<surface><friction><ode><mu>0</mu></ode></friction></surface></c')


@pytest.mark.parametrize('tag, friction', [
    ('', {'a': 1.0, 'a::part_1': 0.0, 'a::part_2': 0.2}),
    ('<gazebo reference="a"><mu1>0.7</mu1></gazebo>', {'a': 0.7, 'b': 0.2, 'b::part_1': 0.0})])
def test_shapes_of_a_link_keep_the_friction_of_their_surface(tag, friction):
    slow = SLIPPERY.replace('<mu>0<', '<mu>0.2<')
    found = lumped(ROBOT.format(link('a', inside=SHAPE + 2 * SLIPPERY + slow) + link(
        'b', inside=slow + SLIPPERY) + joint('ab', 'a', 'b') + tag))
    assert {each.name: each.surface.mu for each in found.links} == friction
    assert sum(len(each.solids) for each in found.links) == 6


def test_what_moves_without_mass_is_left_out_with_a_warning():
    found = lumped(ROBOT.format(
        link('a') + link('b', 0) + link('c', '0') + link('d') + link('e', 0, SHAPE) + link('f')
        + joint('ab', 'a', 'b', 'continuous') + joint('bc', 'b', 'c') + joint('cd', 'c', 'd')
        .replace('fixed', 'continuous') + joint('ae', 'a', 'e', 'continuous')
        + joint('af', 'a', 'f', 'continuous')))
    assert [each.name for each in found.links] == ['a', 'f'] == list(found.frames)
    assert [each.name for each in found.joints] == ['af']
    assert sorted(found.left_out) == ['ab', 'ae', 'bc', 'cd']
    first, second = found.warnings
    assert first.startswith('link b can move (joint ab) but has no mass: it is left out')
    assert second.startswith('link e can move (joint ae)')


def test_inertia_of_no_body_is_replaced_with_a_warning():
    found = lumped(ROBOT.format(link('a').replace('ixy="0"', 'ixy="-2"')))
    # the principal moments -1, 1 and 3; the nearest are 0, 2 and 2
    assert found.links[0].inertia.matrix == pytest.approx(
        np.array([[1, -1, 0], [-1, 1, 0], [0, 0, 2]]), abs=1e-4)
    assert found.warnings == (
        'link a and what is fixed to it: got the principal moments of inertia -1, 1, 3 kg m2; '
        'those of a body are more than 0, and none exceeds the sum of the others; simulated with '
        '3e-05, 2, 2',)
    changed = lumped(ROBOT.format(link('a') + link('b').replace('ixy="0"', 'ixy="-2"')
                                  + joint('ab', 'a', 'b', 'continuous')))
    assert changed.changed_inertias == ('b',) and len(changed.warnings) == 1


@pytest.mark.parametrize('inside, axis', [
    ('<axis xyz="0 0 1"/>', [0, 0, 1]), ('<axis/>', [1, 0, 0]), ('', [1, 0, 0])])
@pytest.mark.parametrize('kind', ['continuous', 'prismatic', 'revolute'])
def test_joints_that_move_keep_their_type_and_axis(kind, inside, axis):
    moving, = lumped(ROBOT.format(PAIR + joint('j', 'a', 'b', kind, inside + '<limit/>'))).joints
    assert (moving.kind, moving.axis.tolist()) == (kind, axis)


def test_joints_that_move_keep_what_they_say_of_their_motion():
    inside = ('<limit lower="-1" upper="inf" effort="3" velocity="4"/>'
              '<dynamics damping="-0.5" friction="0.25"/>')
    tag = ('<gazebo reference="j"><springStiffness>7</springStiffness><springReference>-0.1'
           '</springReference></gazebo>')
    moving, = lumped(ROBOT.format(PAIR + joint('j', 'a', 'b', 'revolute', inside) + tag)).joints
    assert moving[7:11] == ((-1, math.inf, 3, 4), 0.5, 0.25, 7, -0.1)[1:]
    assert moving.limits == (-1, math.inf, 3, 4)
    other, = lumped(ROBOT.format(PAIR + joint('j', 'a', 'b', 'revolute', '<limit/>'))).joints
    assert (other.limits, other.damping, other.friction) == ((0, 0, 0, 0), 0, 0)
    swapped, = lumped(ROBOT.format(PAIR + joint(
        'j', 'a', 'b', 'prismatic', '<limit lower="2" upper="-1"/>'))).joints
    assert swapped.limits[:2] == (-1, 2)
    for kind, advice in (('revolute', ', or make its type continuous'), ('prismatic', '')):
        assert refusal(lumped, ROBOT.format(PAIR + joint('j', 'a', 'b', kind))) == (
            'joint j of type {} has no <limit>, which Gazebo refuses too; add <limit lower="..." '
            'upper="..." effort="..." velocity="..."/>{}'.format(kind, advice))
    assert "upper of joint j: got 'x', expected" in refusal(lumped, ROBOT.format(
        PAIR + joint('j', 'a', 'b', 'revolute', '<limit upper="x"/>')))


@pytest.mark.parametrize('tags, said', [
    ('', (None, (0, 0), '')),
    ('<gazebo reference="a"><turnGravityOff>1</turnGravityOff><selfCollide>true</selfCollide>'
     '<dampingFactor>0.1</dampingFactor></gazebo>', (False, (0.1, 0.1), 'a')),
    # each tag of the link says it, the last one counts
    ('<gazebo reference="a"><turnGravityOff>1</turnGravityOff></gazebo><gazebo reference="b"><mu1>'
     '1</mu1></gazebo>', (True, (0, 0), '')),
    ('<gazebo reference="b"><turnGravityOff>1</turnGravityOff><self_collide>1</self_collide>'
     '</gazebo>', (False, (0, 0), 'b')),
    ('<gazebo><self_collide>1</self_collide></gazebo>', (None, (0, 0), 'b'))])
def test_what_tags_say_of_how_links_move(tags, said):
    found, = lumped(ROBOT.format(link('a') + link('b') + joint('ab', 'a', 'b') + tags)).links
    assert (found.has_gravity, found.decay, found.space) == said


def test_the_bitmask_of_a_tag_is_that_of_the_solids():
    tag = ('<gazebo reference="b"><collision><surface><contact><collide_bitmask>0x0c'
           '</collide_bitmask></contact></surface></collision></gazebo>')
    found = lumped(ROBOT.format(link('a', inside=SHAPE) + link('b', inside=SHAPE)
                                + joint('ab', 'a', 'b') + tag))
    assert [each.solids[0].bitmask for each in found.links] == [0xffff, 12]


def test_links_come_after_the_one_that_they_are_joined_to():
    found = lumped(ROBOT.format(
        link('c') + link('b') + link('d') + link('a') + joint('bc', 'b', 'c')
        + joint('ab', 'a', 'b') + joint('ad', 'a', 'd')))
    assert list(found.frames) == ['a', 'b', 'd', 'c'] and found.root == 'a'


def test_a_second_surface_of_a_link_is_named_as_a_part_of_it():
    found = lumped(ROBOT.format(
        link('a', inside=surface(0.25)) + link('b', inside=SHAPE + SLIPPERY)
        + joint('ab', 'a', 'b', origin='<origin xyz="1 2 3"/>')))
    assert [(each.name, each.surface.mu) for each in found.links] == [
        ('a', 0.25), ('b', 1.0), ('b::part_1', 0.0)]
    assert [(each.name, each.parent, each.child) for each in found.joints] == [
        ('b/joint', 'a', 'b'), ('b::part_1/joint', 'a', 'b::part_1')]
    assert [solid.pose.translation.tolist() for each in found.links for solid in each.solids] == [
        [0, 0, 0.5], [1, 2, 3.5], [1, 2, 3.5]]


def test_tags_of_links_that_are_not_there_are_left_out():
    tag = '<gazebo reference="{}"/>'
    text = ROBOT.format(link('a') + link('b') + link('c') + joint('j', 'a', 'b')
                        + joint('c', 'a', 'c') + '<gazebo/>' + ''.join(
        tag.format(name) for name in ('a', 'b', 'c', 'j', '')))
    robot = lumped(text)
    root = urdf.root_of(text)
    assert urdf.used_tags(root, robot) == (list(robot.tags), []) and len(robot.tags) == 6
    more = urdf.root_of(text.replace('<gazebo/>', tag.format('y') + tag.format('x')
                                     + tag.format('y')))
    left, names = urdf.used_tags(more, dataclasses.replace(
        robot, tags=urdf.read(more, lambda uri: None).tags))
    assert names == ['y', 'x']
    assert [each.link for each in left] == ['a', 'b', 'c', 'j', '']
