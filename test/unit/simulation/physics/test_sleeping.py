"""Which bodies fall asleep, what wakes them, and where they are then: figures of Gazebo 11.1."""
import pybullet
import pytest

from img_recog.formats import urdf, world_file
from img_recog.formats.lumping import lumped
from img_recog.model import Tree
from img_recog.report import Report
from img_recog.rotations import IDENTITY
from img_recog.simulation import guard
from img_recog.simulation.models import Models
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.forces import Forces
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog.simulation.simulator import Simulator
from img_recog_helpers import sdf

CUBE = sdf.box(0.2, 0.2, 0.2)
BIG_BALL = dict(geometry=sdf.ball(1), moments=0.4)
NEVER = '<allow_auto_disable>0</allow_auto_disable>'
ZERO = (0.0, 0.0, 0.0)
JOINT = ('<joint name="j" type="{}"><parent>{}</parent><child>l</child><axis><xyz>{}</xyz></axis>'
         '</joint>')


def box(name, pose, *inside, **link):
    return sdf.model(name, sdf.link(geometry=CUBE, **link), *inside, pose=pose)


def tower(x=0.0):
    """Return three boxes on one another."""
    return [box('b{}'.format(number), '{} 0 {}'.format(x, 0.1 + 0.2 * number))
            for number in range(3)]


def slider(pose, size, axis='1 0 0', mass=20):
    """Return a model of a box that slides."""
    return sdf.model(
        's', '<link name="base"/>', sdf.link(geometry=sdf.box(*size), mass=mass, moments=0.1),
        JOINT.format('prismatic', 'base', axis), '<joint name="w" type="fixed"><parent>world'
        '</parent><child>base</child></joint>', pose=pose)


def simulated(*models, **more):
    return sdf.simulated(sdf.BUILT_IN, *models, **more)


def asleep(simulator):
    """Return the names of the bodies that sleep, without those of their links."""
    return {body.name.partition('::')[0] for body in simulator.world.scenery
            if body.body_id in simulator.world.sleeping.asleep}


def position(simulator, name):
    return Models(simulator).state(name).position


def drive(simulator, velocity):
    body = next(body for body in simulator.world.scenery if body.joints)
    body.set_motor('j', velocity, 2000)


def bits(simulator):
    """Return where all bodies are and how they move, to the last bit."""
    client = simulator.world.physics_client_id
    return [read(body.body_id, physicsClientId=client) for body in simulator.world.scenery
            for read in (pybullet.getBasePositionAndOrientation, pybullet.getBaseVelocity)]


@pytest.mark.parametrize('model, sleeps', [
    (box('b', '0 0 0.1'), True), (box('b', '0 0 0.3'), True), (box('b', '0 0 0.1', NEVER), False),
    (box('b', '0 0 0.1', '<allow_auto_disable>true</allow_auto_disable>'), True),
    (box('b', '0 0 0.1', inside='<sensor name="s" type="contact"/>'), False),
    (box('b', '0 0 0.1', inside='<gravity>0</gravity>'), False),
    (sdf.model('b', sdf.link(geometry=CUBE), sdf.link('a', '1', CUBE), pose='0 0 0.1'), True),
    (sdf.model('b', sdf.link(geometry=CUBE), sdf.link('a', '1', CUBE),
               JOINT.format('fixed', 'a', '1 0 0'), pose='0 0 0.1'), False),
    (slider('0 0 0.1', (0.2, 0.2, 0.2)), False), (box('b', '0 0 100'), False)])
def test_what_falls_asleep(model, sleeps):
    simulator = simulated(model)
    simulator.advance(1900)
    assert asleep(simulator) == ({'b'} if sleeps else set())
    for body in simulator.world.scenery:
        if sleeps:
            assert body.speed() == 0


@pytest.mark.parametrize('inside, sleeps', [
    ('', True), ('<gazebo>{}</gazebo>'.format(NEVER), False),
    ('<gazebo reference="l"><sensor name="s" type="imu"/></gazebo>', False)])
def test_what_a_urdf_says(inside, sleeps):
    root = urdf.root_of('<robot name="b"><link name="l"><inertial><mass value="1"/><inertia '
                        'ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
                        '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
                        '</link>{}</robot>'.format(inside))
    simulator = simulated()
    model = lumped(urdf.read(root, lambda uri: None, Report()), Report())
    simulator.world.load([Tree('b', model, IDENTITY._replace(
        translation=IDENTITY.translation + (0, 0, 0.1)))])
    simulator.advance(1500)
    assert asleep(simulator) == ({'b'} if sleeps else set())


# of Gazebo: where balls are after 4 s that roll at first at this speed
@pytest.mark.parametrize('inside, speed, x', [
    ('', 0.05, 0.05), ('', 0.095, 0.0949), (NEVER, 0.05, 0.2), ('', 0.12, 0.48)])
def test_what_rolls_slowly_stops_after_a_second(inside, speed, x):
    simulator = simulated(sdf.model('b', inside, sdf.link(**BIG_BALL), pose='0 0 1'),
                          velocities={'b': ((speed, 0, 0), (0, speed, 0))})
    simulator.advance(4000)
    assert position(simulator, 'b')[0] == pytest.approx(x, abs=0.001)


def test_what_turns_at_the_top_of_a_throw_does_not_fall_asleep():
    simulator = simulated('<gravity>0 0 -0.15</gravity>', box('b', '0 0 0.5'),
                          velocities={'b': ((0, 0, 0.3), ZERO)})
    simulator.advance(2700)     # for 1.3 s, it was slower than 0.1 m/s
    assert position(simulator, 'b')[2] == pytest.approx(0.763, abs=0.002)
    simulator.advance(4500)
    assert asleep(simulator) == {'b'} and position(simulator, 'b')[2] < 0.11


def move(simulator, name, **state):
    models = Models(simulator)
    models.set_state(name, models.state(name)._replace(**state))


# each with the body that moves then, and the sign of how it moves along x, or along z
WAYS = {
    'push': (lambda sim: Models(sim).apply_wrench(
        'b2::l', (30, 0, 0), ZERO, 0, 0.1), 'b2', (1, 0)),
    'short push': (lambda sim: Models(sim).apply_wrench(
        'b2::l', (500, 0, 0), ZERO, 0, 0.001), 'b2', (1, 0)),
    'velocity': (lambda sim: move(sim, 'b2', linear=(0.5, 0, 0)), 'b2', (1, 0)),
    'place': (lambda sim: move(sim, 'b2', position=(2, 0, 0.5)), 'b2', (0, -1)),
    'moved from below': (lambda sim: move(sim, 'b0', position=(2, 0, 0.1)), 'b2', (0, -1)),
    'table moved from below': (lambda sim: move(sim, 'table', position=(5, 3, 0)), 't', (0, -1)),
    'table moved against': (lambda sim: move(sim, 'table', position=(-0.59, 0, 0.25)), 'b0',
                            (1, 0)),
    'delete': (lambda sim: Models(sim).remove('b0'), 'b2', (0, -1)),
    'delete table': (lambda sim: Models(sim).remove('table'), 't', (0, -1)),
    'gravity': (lambda sim: sim.world.set_gravity((0, 0, 2)), 'b0', (0, 1)),
    'spawn': (lambda sim: sim.world.load(
        simulated(box('new', '0.15 0 0.7', mass=9)).world.trees), 'b2', (-1, 0)),
    'spawn static': (lambda sim: sim.world.load(simulated(sdf.body(
        'new', '-0.19 0 0.1', CUBE, static=True)).world.trees), 'b0', (1, 0)),
    'hit': (lambda sim: drive(sim, 1.0), 'b0', (1, 0))}


@pytest.mark.parametrize('way', WAYS)
def test_what_wakes(way):
    simulator = simulated(*tower(), sdf.body('table', '0 3 0.25', sdf.box(1, 1, 0.5),
                                             static=True),
                          box('t', '0 3 0.6'), slider('-0.5 0 0.1', (0.2, 0.2, 0.1)))
    simulator.advance(1200)
    assert asleep(simulator) == {'b0', 'b1', 'b2', 't'}
    act, name, along = WAYS[way]
    before = position(simulator, name)
    act(simulator)
    if way == 'place':
        before = position(simulator, name)
    simulator.advance(400)
    now = position(simulator, name)
    assert (now[0] - before[0]) * along[0] + (now[2] - before[2]) * along[1] > 0.004
    if way == 'hit':
        drive(simulator, -1.0)
    simulator.world.set_gravity((0, 0, -9.8))
    simulator.advance(4000)
    still = {body.name for body in simulator.world.scenery if not (body.fixed or body.joints)}
    assert asleep(simulator) == {name.partition('::')[0] for name in still}


def test_a_pile_sleeps_as_a_whole_and_is_not_woken_by_its_own_members():
    simulator = simulated(*(box('b{}'.format(number), '{} {} {} 0.3 0.{} 0'.format(
        0.11 * (number % 4), 0.13 * (number % 3), 0.2 + 0.12 * number, number % 5))
        for number in range(16)))
    simulator.advance(8000)
    before = bits(simulator)
    assert len(asleep(simulator)) == 16
    simulator.advance(500)
    assert len(asleep(simulator)) == 16 and bits(simulator) == before


def test_what_touches_something_awake_stays_awake():
    simulator = simulated(slider('0 0 0.3', (0.6, 0.6, 0.1)), box('b', '0 0 0.45'),
                          box('c', '0 0 0.65'), box('d', '3 0 0.1'))
    drive(simulator, 0.0)
    simulator.advance(1500)
    assert asleep(simulator) == {'d'}
    drive(simulator, 0.05)      # so slowly that nothing would be found to be fast
    simulator.advance(2000)
    assert position(simulator, 'b')[0] == pytest.approx(0.1, abs=0.002)


def test_a_ray_hits_what_was_moved_in_its_sleep():
    simulator = simulated(box('b', '0 0 0.1'))
    simulator.advance(1500)
    for x in (5, 7):
        move(simulator, 'b', position=(x, 0, 0.1))
        (hit,) = pybullet.rayTest((x - 1, 0, 0.1), (x + 1, 0, 0.1),
                                  physicsClientId=simulator.world.physics_client_id)
        assert hit[0] == simulator.world.scenery[0].body_id
        simulator.advance(1500)


# of Gazebo, after 5 s
@pytest.mark.parametrize('moving, velocity, places', [
    (slider('-1 0 0.1', (0.2, 0.2, 0.1)), 0.1, {'b0': -0.3006, 'b1': -0.3004, 'b2': -0.3012})])
def test_where_a_tower_is_that_was_hit_in_its_sleep(moving, velocity, places):
    simulator = simulated(moving, *tower(-0.5))
    drive(simulator, velocity)
    simulator.advance(2500)
    assert asleep(simulator) == {'b0', 'b1', 'b2'}
    simulator.advance(2500)
    assert not asleep(simulator)
    for number, (name, x) in enumerate(places.items()):
        assert position(simulator, name) == pytest.approx((x, 0, 0.1 + 0.2 * number), abs=0.005)


def test_the_same_to_the_bit_after_a_reset_and_however_steps_are_divided():
    models = [slider('-1 0 0.1', (0.2, 0.2, 0.1)), *tower(-0.5), box('c', '1 0 0.6 0.3 0.2 0')]

    def run(simulator, parts):
        found = []
        for number in range(6):
            drive(simulator, 0.3 if number % 4 == 2 else 0.0)
            for steps in parts:
                simulator.advance(steps)
            found.append((bits(simulator), asleep(simulator)))
        return found

    simulator = simulated(*models)
    first = run(simulator, [1000])
    assert any(sleeping for _, sleeping in first) and not all(
        len(sleeping) == 4 for _, sleeping in first)
    for steps, parts in ((0, [1] * 120 + [333, 547]), (1777, [1000]), (30, [500, 500])):
        simulator.advance(steps)
        simulator.reset_simulation()
        assert not asleep(simulator)
        assert run(simulator, parts) == first
    assert run(simulated(*models), [37, 963]) == first


def test_without_what_can_sleep_nothing_is_checked():
    world = simulated(slider('0 0 0.3', (0.6, 0.6, 0.1)), box('b', '3 0 0.1', NEVER)).world
    assert not world.sleeping


def test_the_time_at_rest_does_not_depend_on_the_step():
    file = world_file.read('w.sdf', {}, read_file=lambda path: sdf.sdf(
        sdf.BUILT_IN, box('b', '0 0 0.1')))
    simulator = Simulator(World(PhysicsSettings(step_s=0.002), file, connect()))
    simulator.advance(500)
    assert not asleep(simulator)
    simulator.advance(51)
    assert asleep(simulator) == {'b'}


def test_the_last_state_that_is_set_counts():
    simulator = simulated(box('b', '0 0 0.1'))
    simulator.advance(1500)
    for speed in (1, 0.5):
        move(simulator, 'b', linear=(speed, 0, 0))
    simulator.advance(1)
    assert position(simulator, 'b')[0] == pytest.approx(0, abs=1e-4)
    move(simulator, 'b', linear=(0, 0.5, 0))
    simulator.advance(1)
    assert Models(simulator).state('b').linear == pytest.approx((0, 0.49, 0), abs=0.01)


def test_bodies_that_sleep_are_not_looked_at_in_each_step(monkeypatch):
    """Python looked at each of them: 20 % of the time of a step with 500 boxes at rest."""
    simulator = simulated(*[box('b{}'.format(number), '{} 0 0.1'.format(number))
                            for number in range(3)])
    simulator.advance(2000)
    assert len(asleep(simulator)) == 3
    looks = []
    monkeypatch.setattr(Forces, '__bool__', lambda forces: bool(looks.append('forces')))
    monkeypatch.setattr(guard, '_is_small', lambda state: not looks.append('state'))
    simulator.advance(1000)
    assert not looks
