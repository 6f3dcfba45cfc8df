"""Joints and links like in Gazebo: figures of the real Gazebo 11.1 for small models.

They were read off it once; no test runs it.
"""
import pybullet
import pytest

from img_recog.simulation.models import Models
from img_recog_helpers import sdf

HINGE = '<joint name="j" type="{}"><parent>{}</parent><child>{}</child>{}<axis><xyz>{}</xyz>{}' \
    '</axis></joint>'
HELD = '<joint name="w" type="fixed"><parent>world</parent><child>{}</child></joint>'
CUBE = sdf.box(0.2, 0.2, 0.2)


def simulated(*models):
    return sdf.simulated(sdf.BUILT_IN, *models)


def hinge(parent, child, more='', kind='revolute', along='0 0 1', axis=''):
    return HINGE.format(kind, parent, child, more, along, axis)


def arm(axis='', link='', joint=''):
    """Return a simulator of a rod of 1 m and 1 kg that hangs horizontally on its end."""
    return simulated(sdf.model(
        'm', HELD.format('base'), '<link name="base"/>',
        sdf.link('arm', '0.5 0.2', moments=(0.000416667, 0.0835417, 0.0835417), inside=link),
        hinge('base', 'arm', '<pose>-0.5 0 0 0 0 0</pose>' + joint, along='0 1 0', axis=axis),
        pose='0 0 3'))


def dynamics(**values):
    return '<dynamics>{}</dynamics>'.format(''.join(
        '<{0}>{1}</{0}>'.format(*each) for each in values.items()))


def limit(**values):
    return dynamics(**values).replace('dynamics', 'limit')


IMPLICIT = '<physics><ode><implicit_spring_damper>1</implicit_spring_damper></ode></physics>'


@pytest.mark.parametrize('axis, joint, angle', [
    (dynamics(damping=5), '', 0.8248), (dynamics(damping=200), '', 0.0245),
    (dynamics(damping=0.5), IMPLICIT, 2.3012), (dynamics(damping=-0.5), '', 2.3004),
    (dynamics(friction=1), '', 2.566), (dynamics(friction=6), '', 0.0),
    (dynamics(friction=1, damping=0.5), '', 1.9699),
    (dynamics(spring_stiffness=20, spring_reference=0.5), '', 0.9509),
    (dynamics(spring_stiffness=1e5, damping=100), '', 0.0),
    (limit(upper=0.5), '', 0.5), (limit(lower=-0.3), '', 3.1336),
    (limit(lower=0.3, upper=0.3), '', 0.3), (limit(lower=0.5, upper=-0.5), '', 3.1336),
    (limit(), '', 3.1336), (limit(lower=-0.5, upper=0.5, effort=0, velocity=0), '', 0.5),
    (limit(lower=-7, upper=7), '', 3.1336), (limit(lower=-4, upper=1.2), '', 1.2),
    ('<initial_position>0.7</initial_position>', '', 3.1336)])
def test_the_angle_of_an_arm_after_a_second(axis, joint, angle):
    simulator = arm(axis, joint=joint)
    found = sdf.figures(simulator, 1).joints()['m::j'][0]
    assert found == pytest.approx(angle, rel=0.02, abs=1e-3)
    assert not simulator.world.report.lines()


def decay(linear, angular):
    return ('<velocity_decay><linear>{}</linear><angular>{}</angular></velocity_decay>'
            .format(linear, angular))


@pytest.mark.parametrize('link, angle', [
    ('<gravity>0</gravity>', 0.0), ('<kinematic>1</kinematic>', 0.0),
    (decay(0.01, 0.01), 1.0992), (decay(0.01, 0), 1.3059)])
def test_what_links_say_of_the_motion_of_an_arm(link, angle):
    simulator = arm(link=link)
    simulator.advance(1000)
    found = [value[0] for value in simulator.world.scenery[0].joint_values()] or [0.0]
    assert found[0] == pytest.approx(angle, rel=0.02, abs=1e-6)


@pytest.mark.parametrize('link, place', [
    ('<gravity>0</gravity>', (1.0, 50.0, 1.0)), ('<kinematic>1</kinematic>', (0.0, 50.0, 0.0)),
    (decay(0.01, 0.01), (0.0, 49.117, 0.0)),
    ('<gravity>0</gravity>' + decay(0, 0.01), (1.0, 50.0, 0.1045))])
def test_where_a_body_is_that_is_thrown_without_gravity_or_falls(link, place):
    simulator = sdf.simulated(
        sdf.BUILT_IN, sdf.body('m', '0 0 50', CUBE, inside=link),
        velocities={'m': ((1, 0, 0), (0, 0, 1))} if 'gravity' in link else {})
    simulator.advance(1000)
    motion = simulator.world.scenery[0].motion()
    assert (*motion.position[::2], motion.yaw) == pytest.approx(place, rel=0.02, abs=1e-6)


COLLIDES = '<self_collide>{}</self_collide>'.format
NESTED = '<model name="n">{}</model>'


@pytest.mark.parametrize('model, low, high, inside, height', [
    ('', '', '', '{}', 0.1), (COLLIDES(1), '', '', '{}', 0.3), ('', COLLIDES(1), '', '{}', 0.3),
    ('', '', COLLIDES(1), '{}', 0.3), (COLLIDES(1), COLLIDES(0), COLLIDES(0), '{}', 0.1),
    (COLLIDES(1), COLLIDES(0), '', '{}', 0.3), ('', '', '', NESTED, 0.3),
    (COLLIDES(1), '', '', '{}' + hinge('a', 'b', kind='prismatic'), 0.1)])
def test_links_of_a_model_meet_where_it_says_so(model, low, high, inside, height):
    simulator = simulated(sdf.model(
        'm', model, sdf.link('a', '0 0 0.1', CUBE, inside=low),
        inside.format(sdf.link('b', '0 0 0.5', CUBE, inside=high))))
    for _ in range(2):          # the second time after the first ones were removed
        heights = [place[2] for name, place in sdf.figures(simulator, 1).links().items()
                   if name.endswith('b')]
        assert heights == [pytest.approx(height, abs=0.005)]
        world, trees = simulator.world, simulator.world.trees
        for each in world.models[1:]:       # after the floor
            world.remove(each)
        world.load(trees)


def contact(**values):
    return '<surface><contact>{}</contact></surface>'.format(dynamics(**values)[10:-11])


FLOOR = contact(collide_bitmask='0x01')


@pytest.mark.parametrize('surface, falls', [
    (contact(collide_bitmask=1), False), (contact(collide_bitmask=2), True),
    (contact(collide_bitmask=65536), True), (contact(collide_bitmask=0), True),
    (contact(collide_bitmask='0xfffe'), True), (contact(category_bitmask=2), False),
    (contact(collide_without_contact=1), True),
    (contact(collide_without_contact_bitmask=2), False),
    (contact(collide_without_contact=1, collide_without_contact_bitmask=2), True)])
def test_bitmasks(surface, falls):
    simulator = simulated(sdf.body('shelf', '0 0 1', CUBE, static=True, surface=FLOOR),
                          sdf.body('m', '0 0 1.21', CUBE, surface=surface))
    height = sdf.figures(simulator, 0.3).links()['m::l'][2]
    assert (height < 1) if falls else height == pytest.approx(1.2, abs=0.002)


def test_damping_beyond_what_is_stable_gets_a_line_and_ends_nowhere():
    simulator = arm(dynamics(damping=5000))
    assert simulator.world.report.lines() == [
        'model m: joint j: damping 5000 and stiffness 0 cannot be simulated in steps of 0.001 s; '
        'it has 333.542 and 0']
    assert 0 < sdf.figures(simulator, 1).joints()['m::j'][0] < 0.02


def test_each_link_of_a_world_has_its_own_friction():
    mu = '<surface><friction><ode><mu>{0}</mu><mu2>{0}</mu2></ode></friction></surface>'.format
    simulator = simulated(sdf.model(
        'm', sdf.link('a', '0 0 1', CUBE, surface=mu(0.1)),
        sdf.link('b', '1 0 1', CUBE, surface=mu(0.3)), hinge('a', 'b')))
    body, client = simulator.world.scenery[0].body_id, simulator.world.physics_client_id
    assert [pybullet.getDynamicsInfo(body, link, physicsClientId=client)[1]
            for link in (-1, 0)] == [0.1, 0.3]


def test_what_a_hinge_holds_in_the_floor_does_not_meet_it():
    simulator = simulated(
        sdf.model('m', sdf.link('l', '', CUBE), hinge('world', 'l', along='1 0 0')),
        sdf.body('n', '0 0 0.2', CUBE))
    assert simulator.world.report.lines() == [
        'model m: held in the floor by its joints; it does not meet the floor']
    # the box on it is not thrown away
    assert sdf.figures(simulator, 1).links()['n::l'][2] == pytest.approx(0.2, abs=0.005)


def test_a_body_that_flies_away_gets_one_line_until_a_reset():
    simulator = simulated(sdf.body('m', '0 0 50', CUBE))
    models, lines = Models(simulator), []
    simulator.world.report.listen(lines.append)
    for _ in range(2):
        models.set_state('m', models.state('m')._replace(linear=(2000, 0, 0)))
        simulator.advance(3000)
        line, = lines
        assert line.startswith('m moves at 2e+03 m/s, after ')
        lines.clear()
        simulator.reset_world()
    simulator.advance(3000)
    assert lines == []


def test_joints_and_masses_of_a_model_that_is_fixed_to_the_world():
    simulator = simulated(sdf.model(
        'm', HELD.format('a'), hinge('a', 'b', along='0 1 0'),
        hinge('b', 'c', kind='universal', along='1 0 0').replace('"j"', '"u"').replace(
            '</joint>', '<axis2><xyz>0 1 0</xyz></axis2></joint>'),
        sdf.link('a', mass=2, moments=(0.1, 0.2, 0.15)).replace(
            '<mass>', '<pose>0.1 0 0 0.4 0 0</pose><mass>'),
        '<link name="b"><pose>0.5 0 0 0 0 0</pose></link>',
        '<link name="c"><pose>1 0 0 0 0 0</pose></link>', pose='0 0 2 0 0 0.3'))
    figures = sdf.figures(simulator, 0.3)
    assert figures.joints() == {
        'm::w': [], 'm::j': pytest.approx([0.1768, 1.1723], abs=1e-3),
        'm::u': pytest.approx([0, 0, -0.1768, -1.1723], abs=1e-3)}
    assert figures.masses() == {
        'ground_plane::link': [0, 0, 0, 0], 'm::a': pytest.approx([2, 0.1, 0.2, 0.15]),
        'm::b': [1, 1, 1, 1], 'm::c': [1, 1, 1, 1]}
    assert figures.links()['ground_plane::link'][:7] == pytest.approx([0, 0, 0, 0, 0, 0, 1])
