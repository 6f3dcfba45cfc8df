"""URDF in, a lumped robot out: nothing lost, and what cannot be simulated refused."""
import dataclasses

import pytest

from img_recog.formats import urdf
from img_recog_helpers.parsed import given, lumped
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger

ROBOT = '<robot name="r">{}</robot>'
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
     "axis of joint j: got '0 0 0', expected 3 finite numbers, not all 0"),
    (link('a').replace('ixx="1"', 'ixx="1e16"'), 'expected at most 1e+15'),
    (link('a', inside='<contact><lateral_friction value="-0.5"/></contact>'),
     'lateral_friction of link a: got \'-0.5\', expected a finite number of at least 0'),
    (PAIR + joint('j', 'a', 'b', origin='<origin xyz="inf 0 0"/>'),
     "<origin> in <joint j>: got 'inf 0 0'"),
    (PAIR + joint('j', 'a', 'b', origin='<origin xyz="1 2"/>'), 'expected 3 finite numbers'),
    (link('a') + '<joint name="j" type="fixed"><child link="a"/></joint>',
     'joint j has the parent link None, which does not exist (links: a)'),
    (link('a') + '<joint name="j" type="fixed"><parent link="a"/></joint>',
     'joint j has the child link None, which does not exist (links: a)'),
    ('<link name="a"><inertial><mass/><inertia/></inertial></link>',
     'mass of link a: got None, expected a finite number'),
    (link('a').replace('ixx="1"', 'ixx="x"'),
     "inertia of link a: got 'x 0 0 0 1 0 0 0 1', expected 9 finite numbers"),
    ('<link name="a"><inertial><mass value="1"/></inertial></link>',
     'link a: <inertial> must have <mass> and <inertia>'),
    ('<link name="a"><inertial><inertia/></inertial></link>',
     'link a: <inertial> must have <mass> and <inertia>'),
    (link('a', inside='<contact><lateral_friction/></contact>'),
     'lateral_friction of link a: got None, expected a finite number'),
    (link('a') + '<gazebo reference="a"><mu1>much</mu1></gazebo>',
     "<mu1> of link a: got 'much', expected a finite number")])
def test_refusals_name_what_is_wrong_in_one_line(inside, words):
    assert words in refusal(lumped, ROBOT.format(inside))


def test_what_is_not_a_urdf():
    assert 'not XML' in refusal(lumped, '<robot')
    for tag in ('sdf', 'a'):
        assert 'root element <{}>'.format(tag) in refusal(lumped, '<{}/>'.format(tag))


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
        robot, tags=given(more).tags))
    assert names == ['y', 'x']
    assert [each.link for each in left] == ['a', 'b', 'c', 'j', '']
