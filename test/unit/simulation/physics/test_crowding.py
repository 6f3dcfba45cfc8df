"""Bodies that touch in so many points that the next step of the physics takes seconds."""
import pybullet
import pytest

from img_recog.errors import SimulationError
from img_recog.formats import model_file
from img_recog.report import Report
from img_recog.simulation.models import Models, State
from img_recog_helpers import sdf
from img_recog_helpers.robots import assemble

HERE = State((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


CUBE = sdf.box(0.2, 0.2, 0.2)
LIFTED_ONTO = 'world empty: in the floor at the start, and lifted onto it: {}'


def world_of(*poses):
    return sdf.world(*(sdf.body('crate{}'.format(number), pose, CUBE, mass=2, moments=0.02)
                       for number, pose in enumerate(poses)), name='crates.world')


def trees(count, links_of):
    links = [sdf.link('l{}'.format(number), '', CUBE, mass=2, moments=0.02)
             for number in range(count)]
    return model_file.read('<sdf version="1.6">{}</sdf>'.format(
        sdf.model('m', *links, links_of(count))), 'm', lambda uri: None, Report())


def fixed_joints(count):
    return ''.join('<joint name="j{0}" type="fixed"><parent>l0</parent><child>l{0}</child></joint>'
                   .format(number) for number in range(1, count))


def colliding(count):
    return '<self_collide>1</self_collide>'


def test_a_step_that_takes_seconds_is_said_before():
    world = world_of(*['0 0 5'] * 40)
    assert world.report.lines() == [
        'world crates: the next step of the physics takes about 1 s: bodies touch or overlap in '
        'many points, crate0 in 156, crate1 in 156, crate2 in 156']


@pytest.mark.parametrize('count, words', [
    (70, 'bodies touch or overlap in many points, crate0 in 276, crate1 in 276, crate2 in 276'),
    (200, 'more than 10000 pairs of bodies are in one place, the first are crate0, crate1, crate2')
])
def test_a_world_whose_first_step_takes_too_long_is_refused(count, words):
    with pytest.raises(SimulationError) as error:
        world_of(*['0 0 5'] * count)
    assert str(error.value) == (
        'world crates: the next step of the physics would take more than 10 s: ' + words
        + '; move them apart, join the links of a model by fixed joints, or make it static')


def test_bodies_that_stand_beside_one_another_are_not_many_points():
    poses = ['{} {} 0.1'.format(x * 0.21, y * 0.21) for x in range(15) for y in range(15)]
    world = world_of(*poses)
    assert world.report.lines() == [] and len(world.scenery) == 225
    world.step(10)      # in no time


@pytest.mark.parametrize('links_of', [lambda count: '<static>1</static>', fixed_joints])
def test_links_that_are_joined_or_static_never_touch(links_of):
    sim = assemble()
    Models(sim).add('m', trees(120, links_of), HERE)
    assert [line for line in sim.world.report.lines() if 'the next step' in line] == []


def test_models_that_would_stop_time_are_not_added():
    sim = assemble()
    models = Models(sim)
    client = sim.world.physics_client_id
    lines = []
    sim.world.report.listen(lines.append)
    models.add('m0', trees(20, colliding), HERE)
    line, = lines
    assert line.startswith(LIFTED_ONTO.format('m by 0.100 m, m::l1 by 0.100 m, '))
    models.add('m1', trees(20, colliding), HERE)
    _, line, _ = lines
    assert line.startswith('model m: the next step of the physics takes about 2 s: bodies touch')

    def there():
        return models.names, pybullet.getNumBodies(physicsClientId=client), sim.world.revision
    before = there()
    with pytest.raises(SimulationError, match='would take more than 10 s: bodies touch'):
        models.add('m2', trees(30, colliding), HERE)
    assert there() == before


def test_robots_and_the_floor_may_touch_what_is_added():
    sim = assemble()
    models = Models(sim)
    models.add('m', trees(1, colliding), HERE)
    sim.advance(10)
    assert sim.world.report.lines() == [LIFTED_ONTO.format('m by 0.100 m')]
