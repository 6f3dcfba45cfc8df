"""URDF in, lumped URDF out: nothing lost, and what cannot be simulated refused."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from img_recog.simulation.description import parse
from img_recog.simulation.settings import SimulationError
from img_recog_testing.robots import burger

ROBOT = '<robot name="r">{}</robot>'
MASS = ('<inertial><mass value="{}"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        '</inertial>')


def link(name, mass=1.0, inside=''):
    return '<link name="{}">{}{}</link>'.format(name, MASS.format(mass) if mass else '', inside)


def joint(name, parent, child, kind='fixed', origin=''):
    return '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>{}</joint>'.format(
        name, kind, parent, child, origin)


def test_burger_keeps_its_mass_in_four_links():
    robot = ElementTree.fromstring(parse(burger()).urdf)
    assert {each.get('name') for each in robot.findall('link')} == {
        'base_footprint', 'wheel_left_link', 'wheel_right_link', 'caster_back_link'}
    masses = [float(mass.get('value')) for mass in robot.iter('mass')]
    assert sum(masses) == pytest.approx(1.0017329, abs=1e-7)


def test_burger_keeps_all_shapes():
    before, after = ElementTree.fromstring(burger()), ElementTree.fromstring(parse(burger()).urdf)
    for kind in ('visual', 'collision'):
        assert len(list(before.iter(kind))) == len(list(after.iter(kind)))


def test_burger_frames_are_where_the_joints_put_them():
    burgers = parse(burger())
    assert burgers.root == 'base_footprint'
    scan = burgers.frames['base_scan']
    assert scan.link == 'base_footprint'
    assert np.allclose(scan.pose.translation, [-0.032, 0, 0.182])
    assert np.allclose(burgers.frames['imu_link'].pose.translation, [-0.032, 0, 0.078])


def test_friction_is_that_of_gazebos_tag_or_pybullets():
    assert parse(burger()).friction == {
        'wheel_left_link': 0.1, 'wheel_right_link': 0.1, 'caster_back_link': 0.1}
    contact = '<contact><lateral_friction value="0.3"/></contact>'
    tag = '<gazebo reference="a"><mu1>0.7</mu1></gazebo>'
    assert parse(ROBOT.format(link('a', inside=contact))).friction == {'a': 0.3}
    assert parse(ROBOT.format(link('a', inside=contact) + tag)).friction == {'a': 0.7}


def test_chain_of_fixed_links_becomes_one_and_what_moves_stays():
    turned = '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>'
    urdf = parse(ROBOT.format(
        link('a', 0) + link('b') + link('c') + link('wheel')
        + joint('ab', 'a', 'b', origin=turned) + joint('bc', 'b', 'c', origin=turned)
        + joint('cw', 'c', 'wheel', 'continuous', '<origin xyz="1 0 0"/>')))
    robot = ElementTree.fromstring(urdf.urdf)
    moving = robot.find('joint')
    assert len(robot.findall('joint')) == 1
    assert moving.find('parent').get('link') == 'a'
    # a -> b: 1 forward, quarter turn; b -> c: 1 along b's x, which is a's y; c's x is a's -x
    assert np.allclose([float(v) for v in moving.find('origin').get('xyz').split()], [0, 1, 0])
    assert np.allclose(urdf.frames['c'].pose.translation, [1, 1, 0])


REFUSED = {
    'not XML': ('<robot', 'not XML'),
    'not URDF': ('<sdf/>', 'root element <sdf>'),
    'no link': (ROBOT.format(''), 'got 0 root links'),
    'two roots': (ROBOT.format(link('a') + link('b')), '2 root links (a, b)'),
    'loop': (ROBOT.format(link('a') + link('b') + joint('j', 'a', 'b') + joint('k', 'b', 'a')),
             'link a is its own ancestor, through joint k'),
    'loop beside a root': (ROBOT.format(link('r') + link('a') + link('b') + joint('j', 'a', 'b')
                                        + joint('k', 'b', 'a')), 'link a is its own ancestor'),
    'no name': (ROBOT.format('<link/>' + link('a')), 'each <link> must have a unique name'),
    'same name': (ROBOT.format(link('a') + link('a')), 'each <link> must have a unique name'),
    'two parents': (ROBOT.format(link('a') + link('b') + link('c') + joint('j', 'a', 'c')
                                 + joint('k', 'b', 'c')),
                    'link c is the child of two joints, j and k'),
    'lost link': (ROBOT.format(link('a') + joint('j', 'a', 'b')), 'child link b, which does not'),
    'zero mass': (ROBOT.format(link('a', '0')), 'mass of link a: got 0 kg'),
    'negative mass': (ROBOT.format(link('a', -1)), 'mass of link a: got -1 kg'),
    'NaN mass': (ROBOT.format(link('a', 'nan')), "mass of link a: got 'nan'"),
    'word for mass': (ROBOT.format(link('a', 'heavy')), "mass of link a: got 'heavy'"),
    'moving without mass': (ROBOT.format(link('a') + link('b', 0)
                                         + joint('j', 'a', 'b', 'continuous')),
                            'link b can move but has no mass'),
    'planar joint': (ROBOT.format(link('a') + link('b') + joint('j', 'a', 'b', 'planar')),
                     'joint j is of type planar; supported are continuous, fixed'),
    'no axis': (ROBOT.format(link('a') + link('b') + joint(
        'j', 'a', 'b', 'continuous', '<axis xyz="0 0 0"/>')), 'axis of joint j: got 0 0 0'),
    'no inertia': (ROBOT.format(link('a').replace('"1"', '"0"')),
                   'link a, with the links fixed to'),
    'negative inertia': (ROBOT.format(link('a').replace('ixx="1"', 'ixx="-1"')),
                         'expected positive moments'),
    'infinite origin': (ROBOT.format(link('a') + link('b') + joint(
        'j', 'a', 'b', origin='<origin xyz="inf 0 0"/>')), "<origin> in <joint j>: got 'inf 0 0'"),
    'short origin': (ROBOT.format(link('a') + link('b') + joint(
        'j', 'a', 'b', origin='<origin xyz="1 2"/>')), 'expected 3 finite numbers'),
}


@pytest.mark.parametrize('urdf, words', list(REFUSED.values()), ids=list(REFUSED))
def test_refusals_name_what_is_wrong_in_one_line(urdf, words):
    with pytest.raises(SimulationError) as error:
        parse(urdf)
    assert words in str(error.value)
    assert '\n' not in str(error.value)
