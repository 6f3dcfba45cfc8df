"""Gearboxes and screws of an SDF, as Gazebo 11 moves them; and what becomes of them later."""
import pytest

from img_recog.simulation.models import Figures
from img_recog.simulation.simulator import Simulator
from img_recog_helpers import sdf

JOINT = '<joint name="{}" type="{}"><parent>{}</parent><child>{}</child>{}</joint>'
AXIS = '<axis><xyz>0 0 {}</xyz>{}</axis>'
AXES = AXIS.format(1, '') + '<axis2><xyz>0 0 1</xyz></axis2>'


def link(name, x):
    return sdf.link(name, str(x), moments=(0.01, 0.01, 0.015))


BASE = link('base', 0) + JOINT.format('w', 'fixed', 'world', 'base', '')
NUT = BASE + link('nut', 1)
TURNED = ('<dynamics><spring_stiffness>0.01</spring_stiffness>'
          '<spring_reference>1</spring_reference></dynamics>')
WHEELS = (BASE + link('a', 1) + link('b', 2)
          + JOINT.format('ja', 'revolute', 'base', 'a', AXIS.format(1, TURNED))
          + JOINT.format('jb', 'revolute', 'base', 'b', AXIS.format(1, '')))
RATIO = '<gearbox_ratio>2</gearbox_ratio>'
BEARER = '<gearbox_reference_body>base</gearbox_reference_body>'
BOX = WHEELS + JOINT.format('gear', 'gearbox', 'b', 'a', RATIO + BEARER + AXES)


def simulated(model):
    return sdf.world(sdf.model('m', model, pose='0 0 3'))


def joints(world):
    return Figures(Simulator(world)).joints()


@pytest.mark.parametrize('inside, after_half_a_second', [
    ('<thread_pitch>-20</thread_pitch>' + AXIS.format(1, ''), [-3.507, -14, -0.1754, -0.7]),
    ('<thread_pitch>20</thread_pitch>' + AXIS.format(1, ''), [3.507, 14, -0.1754, -0.7]),
    ('<thread_pitch>5</thread_pitch>' + AXIS.format(1, ''), [4.463, 17.819, -0.8927, -3.5636]),
    (AXIS.format(1, ''), [1.2093, 4.8276, -1.2093, -4.8276]),
    ('<thread_pitch>-20</thread_pitch>' + AXIS.format(
        1, '<dynamics><damping>0.01</damping></dynamics>'), [-3.1961, -12.1806, -0.1598, -0.609])])
def test_a_screw_turns_and_slides(inside, after_half_a_second):
    world = simulated(NUT + JOINT.format('j', 'screw', 'base', 'nut', inside))
    world.step(500)
    assert joints(world)['m::j'] == pytest.approx(after_half_a_second, rel=2e-3, abs=2e-3)


def test_a_screw_stops_at_a_limit_of_its_angle():
    world = simulated(NUT + JOINT.format('j', 'screw', 'base', 'nut', AXIS.format(
        1, '<limit><lower>-5</lower><upper>1</upper></limit>')))
    world.step(1500)
    assert joints(world)['m::j'] == pytest.approx([1, 0, -1, 0], abs=1e-3)


@pytest.mark.parametrize('old, new, ratio', [
    ('', '', -0.5), ('<gearbox_ratio>2', '<gearbox_ratio>-3', 1 / 3), (RATIO, '', -1.0),
    (BEARER, '', -0.5),
    ('<axis2><xyz>0 0 1', '<axis2><xyz>0 0 -1', 0.5),
    ('<child>a</child><axis><xyz>0 0 1', '<child>a</child><axis><xyz>0 0 -1', 0.5),
    ('<parent>b</parent><child>a</child>', '<parent>a</parent><child>b</child>', -2.0),
    ('<parent>base</parent><child>b</child><axis><xyz>0 0 1',
     '<parent>base</parent><child>b</child><axis><xyz>0 0 -1', 0.5),
    ('<parent>base</parent><child>a</child>', '<parent>a</parent><child>base</child>', 0.5)])
def test_a_gearbox_turns_one_link_with_another(old, new, ratio):
    world = simulated(BOX.replace(old, new, 1) if old else BOX)
    world.step(500)
    found = joints(world)
    assert abs(found['m::ja'][0]) > 1e-3
    assert found['m::jb'] == pytest.approx([ratio * value for value in found['m::ja']], rel=1e-3)


def test_what_has_a_gearbox_can_be_reset_and_removed():
    world = simulated(BOX)
    world.step(500)
    before = joints(world)
    world.reset()
    assert joints(world)['m::jb'] == pytest.approx([0, 0], abs=1e-12)
    world.step(500)
    assert joints(world)['m::jb'] == pytest.approx(before['m::jb'])
    tree, = world.trees
    world.remove(world.models[-1])
    world.load([tree])
    world.step(500)
    assert joints(world)['m::jb'] == pytest.approx(before['m::jb'])
