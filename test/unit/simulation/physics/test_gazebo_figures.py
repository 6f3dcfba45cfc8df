"""Joints and links like in Gazebo: figures of the real Gazebo 11.1 for small models.

They were read off it once; no test runs it.
"""
import pybullet
import pytest

from img_recog.formats import world_file
from img_recog.formats.problems import Problems
from img_recog.simulation.figures import Figures
from img_recog.simulation.models import Models
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator
from img_recog_helpers.sdf import BUILT_IN, sdf

INERTIAL = ('<inertial><mass>1</mass><inertia><ixx>{0}</ixx><iyy>{1}</iyy><izz>{1}</izz></inertia>'
            '</inertial>')
# a rod of 1 m and 1 kg that hangs horizontally on a joint at its end
ARM = ('<model name="m"><pose>0 0 3 0 0 0</pose><joint name="w" type="fixed"><parent>world'
       '</parent><child>base</child></joint><link name="base"/><link name="arm"><pose>0.5 0.2 0 0 '
       '0 0</pose>' + INERTIAL.format(0.000416667, 0.0835417) + '{link}</link><joint name="j" '
       'type="revolute"><pose>-0.5 0 0 0 0 0</pose><parent>base</parent><child>arm</child>{joint}'
       '<axis><xyz>0 1 0</xyz>{axis}</axis></joint></model>')
BOX = ('<link name="{name}"><pose>{pose} 0 0 0</pose>' + INERTIAL.format(0.01, 0.01)
       + '<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry>{surface}'
       '</collision>{link}</link>')
ALONE = '<model name="m">' + BOX + '</model>'
STEPS = 1000


def simulated(*models):
    """Return a simulator of some models on a floor."""
    file = world_file.read('w.sdf', {}, read_file=lambda path: sdf(
        BUILT_IN, *models), allow_partial=True)
    return Simulator(World(PhysicsSettings(), file, connect(), Problems()))


def arm(axis='', link='', joint=''):
    return simulated(ARM.format(axis=axis, link=link, joint=joint))


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
    simulator.advance(STEPS)
    assert Figures(simulator).joints()['m::j'][0] == pytest.approx(angle, rel=0.02, abs=1e-3)
    assert not simulator.world.warnings


def decay(linear, angular):
    return ('<velocity_decay><linear>{}</linear><angular>{}</angular></velocity_decay>'
            .format(linear, angular))


@pytest.mark.parametrize('link, angle', [
    ('<gravity>0</gravity>', 0.0), ('<kinematic>1</kinematic>', 0.0),
    (decay(0.01, 0.01), 1.0992), (decay(0.01, 0), 1.3059)])
def test_what_links_say_of_the_motion_of_an_arm(link, angle):
    simulator = arm(link=link)
    simulator.advance(STEPS)
    body = simulator.world.bodies[0]
    found = [value[0] for value in body.joint_values()] or [0.0]
    assert found[0] == pytest.approx(angle, rel=0.02, abs=1e-6)


@pytest.mark.parametrize('link, place', [
    ('<gravity>0</gravity>', (1.0, 50.0, 1.0)), ('<kinematic>1</kinematic>', (0.0, 50.0, 0.0)),
    (decay(0.01, 0.01), (0.0, 49.117, 0.0)),
    ('<gravity>0</gravity>' + decay(0, 0.01), (1.0, 50.0, 0.1045))])
def test_where_a_body_is_that_is_thrown_without_gravity_or_falls(link, place):
    simulator = simulated(ALONE.format(name='l', pose='0 0 50', surface='', link=link))
    models = Models(simulator)
    if 'gravity' in link:
        models.set_state('m', models.state('m')._replace(linear=(1, 0, 0), angular=(0, 0, 1)))
    simulator.advance(STEPS)
    motion = simulator.world.bodies[0].motion()
    assert (*motion.position[::2], motion.yaw) == pytest.approx(place, rel=0.02, abs=1e-6)


COLLIDES = '<self_collide>{}</self_collide>'.format
NESTED = '<model name="n">{}</model>'


@pytest.mark.parametrize('model, low, high, inside, height', [
    ('', '', '', '{}', 0.1), (COLLIDES(1), '', '', '{}', 0.3), ('', COLLIDES(1), '', '{}', 0.3),
    ('', '', COLLIDES(1), '{}', 0.3), (COLLIDES(1), COLLIDES(0), COLLIDES(0), '{}', 0.1),
    (COLLIDES(1), COLLIDES(0), '', '{}', 0.3), ('', '', '', NESTED, 0.3),
    (COLLIDES(1), '', '', '{}<joint name="j" type="prismatic"><parent>a</parent><child>b</child>'
     '<axis><xyz>0 0 1</xyz></axis></joint>', 0.1)])
def test_links_of_a_model_meet_where_it_says_so(model, low, high, inside, height):
    text = '<model name="m">{}{}{}</model>'.format(
        model, BOX.format(name='a', pose='0 0 0.1', surface='', link=low),
        inside.format(BOX.format(name='b', pose='0 0 0.5', surface='', link=high)))
    simulator = simulated(text)
    for _ in range(2):          # the second time after the first ones were removed
        simulator.advance(STEPS)
        heights = [place[2] for name, place in Figures(simulator).links().items()
                   if name.endswith('b')]
        assert heights == [pytest.approx(height, abs=0.005)]
        trees = simulator.world.file.trees
        simulator.world.remove(simulator.world.bodies)
        simulator.world.add(trees)


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
    shelf = ALONE.format(name='l', pose='0 0 1', surface=FLOOR, link='').replace(
        '<model name="m">', '<model name="shelf"><static>1</static>')
    simulator = simulated(shelf, ALONE.format(name='l', pose='0 0 1.21', surface=surface, link=''))
    simulator.advance(300)
    height = Figures(simulator).links()['m::l'][2]
    assert (height < 1) if falls else height == pytest.approx(1.2, abs=0.002)


def test_damping_beyond_what_is_stable_gets_a_line_and_ends_nowhere():
    simulator = arm(dynamics(damping=5000))
    assert simulator.world.warnings == [
        'm: joint j: damping 5000 and stiffness 0 cannot be simulated in steps of 0.001 s; it has '
        '333.542 and 0']
    simulator.advance(STEPS)
    assert 0 < Figures(simulator).joints()['m::j'][0] < 0.02


def test_each_link_of_a_world_has_its_own_friction():
    mu = '<surface><friction><ode><mu>{0}</mu><mu2>{0}</mu2></ode></friction></surface>'
    simulator = simulated('<model name="m">{}{}<joint name="j" type="revolute"><parent>a</parent>'
                          '<child>b</child><axis><xyz>0 0 1</xyz></axis></joint></model>'.format(
                              BOX.format(name='a', pose='0 0 1', surface=mu.format(0.1), link=''),
                              BOX.format(name='b', pose='1 0 1', surface=mu.format(0.3), link='')))
    body, client = simulator.world.bodies[0].body_id, simulator.world.physics_client_id
    assert [pybullet.getDynamicsInfo(body, link, physicsClientId=client)[1]
            for link in (-1, 0)] == [0.1, 0.3]


def test_what_a_hinge_holds_in_the_floor_does_not_meet_it():
    simulator = simulated(
        '<model name="m">' + BOX.format(name='l', pose='0 0 0', surface='', link='')
        + '<joint name="j" type="revolute"><parent>world</parent><child>l</child><axis><xyz>1 0 0'
        '</xyz></axis></joint></model>',
        '<model name="n">' + BOX.format(name='l', pose='0 0 0.2', surface='', link='')
        + '</model>')
    assert simulator.world.warnings == [
        'm: held in the floor by its joints; it does not meet the floor']
    simulator.advance(STEPS)        # the box on it is not thrown away
    assert Figures(simulator).links()['n::l'][2] == pytest.approx(0.2, abs=0.005)


def test_a_body_that_flies_away_gets_one_line_until_a_reset():
    simulator = simulated(ALONE.format(name='l', pose='0 0 50', surface='', link=''))
    models, lines = Models(simulator), []
    simulator.warn = lines.append
    for _ in range(2):
        models.set_state('m', models.state('m')._replace(linear=(2000, 0, 0)))
        simulator.advance(3 * STEPS)
        line, = lines
        assert line.startswith('m moves at 2e+03 m/s, after ')
        lines.clear()
        simulator.reset_world()
    simulator.advance(3 * STEPS)
    assert lines == []
