"""Wrenches and efforts on the links and joints of models; figures of Gazebo 11.1 at 1 ms."""
import math

import pytest

from img_recog.simulation.models import Models
from img_recog_helpers import sdf
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble

ARM = '''<joint name="fix" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="{0}_joint" type="revolute"><parent>base</parent><child>arm</child>
    <axis><xyz>0 0 1</xyz><limit>{1}</limit></axis></joint>'''
BOX = sdf.model('box', sdf.link(mass=2, moments=(0.02, 0.04, 0.05)).replace(
    '<mass>', '<pose>0.1 0 0 0 0 0.785398</pose><mass>'), pose='0 5 1 0 0 1.5707963')
ZERO = (0.0, 0.0, 0.0)


@pytest.fixture
def sim():
    return assemble(sdf.sdf('<gravity>0 0 0</gravity>', BOX, *(
        sdf.model(name, sdf.link('base', '0 0 1'), sdf.link('arm', '0 0 1', moments=0.5),
                  ARM.format(name, limit), pose=str(x))
        for name, x, limit in (('free', 3, ''), ('weak', 6, '<effort>0.3</effort>'),
                               ('slow', 9, '<velocity>0.2</velocity>'),
                               ('short', 12, '<lower>-1</lower><upper>1</upper>')))))


@pytest.fixture
def models(sim):
    return Models(sim)


def close(*values):
    return pytest.approx(values, rel=1e-3, abs=1e-4)


def rate(models, joint):
    body, name = models.joint(joint)
    return body.joint_state(body.first_axes[name])[1]


def test_the_last_wrench_on_a_link_acts_at_its_center_of_mass(sim, models):
    models.apply_wrench('box::l', (1.0, 0.0, 0.0), ZERO, 0.0, 0.5)
    models.apply_wrench('box::l', (2.0, 0.0, 0.0), (0.0, 0.0, 0.1), 0.0, 0.5)
    sim.advance(500)
    state = models.state('box::l')
    # of the frame of the link, 0.1 m from the center
    assert state.linear == close(0.596878861, 0.0247888348, 0.0)
    assert state.angular == close(0.0, 0.0, 1.0)
    sim.advance(500)
    assert models.state('box::l').linear == close(0.573134801, 0.0682004462, 0.0)


@pytest.mark.parametrize('joint, efforts, expected', [
    ('free_joint', (0.1, 0.1), 0.2), ('weak::weak_joint', (1.0,), 0.3),
    ('slow_joint', (1.0,), 0.2), ('slow_joint', (-1.0,), -0.2)])
def test_efforts_add_up_within_the_limits_of_the_joint(sim, models, joint, efforts,
                                                       expected):
    for effort in efforts:
        models.apply_effort(joint, effort, 0.0, 0.5)
    sim.advance(1000)
    assert rate(models, joint) == pytest.approx(expected, rel=0.02)


# The box looks along the world's y. As gazebo_ros turns what is given in a frame into the axes of
# the link, and acts along those of the world, the force in its own frame is along the world's x.
@pytest.mark.parametrize('frame, point, force, linear, turn', [
    ('world', ZERO, (1.0, 0.0, 0.0), (0.0005, 0.0), 0.0),
    ('world', (0.0, 0.1, 0.0), (1.0, 0.0, 0.0), (0.0003, 0.0), -0.002),
    ('box::l', (0.0, 0.1, 0.0), (1.0, 0.0, 0.0), (0.0003, 0.0), -0.002),
    ('l', ZERO, (0.0, 1.0, 0.0), (0.0, 0.0005), 0.0),
    # from the box it is at (-5, -3, -1), turned back by a quarter
    ('free', ZERO, (1.0, 0.0, 0.0), (0.01, -0.0005), 0.1)])
def test_a_force_is_given_in_a_frame(sim, models, frame, point, force, linear, turn):
    models.apply_wrench('box::l', force, ZERO, 0.0, 0.001, point, frame)
    sim.advance(2)
    state = models.state('box::l')
    assert state.angular[2] == pytest.approx(turn, abs=1e-6)
    assert state.linear[:2] == pytest.approx(linear, abs=5e-6)


# an effort that makes the joint faster by 1 rad/s in each second, given at 0.007 s
@pytest.mark.parametrize('start_s, duration_s, rates', [
    (0.0, 0.05, (0.05, 0.05)), (0.027, 0.05, (0.03, 0.05)), (0.057, 0.05, (0.0, 0.05)),
    (0.0, -1.0, (0.05, 0.1)), (0.0, 0.0, (0.0, 0.0)), (0.0, 1e-9, (0.001, 0.001))])
def test_it_acts_from_a_start_for_a_duration(sim, models, start_s, duration_s, rates):
    sim.advance(7)
    models.apply_effort('free_joint', 0.5, start_s, duration_s)
    found = []
    for _ in rates:
        sim.advance(50)
        found.append(rate(models, 'free_joint'))
    assert found == close(*rates)


@pytest.mark.parametrize('end', ['clear', 'clear scoped', 'reset', 'reset simulation', 'remove'])
def test_what_acts_without_end_is_ended(sim, models, end):
    models.apply_effort('free_joint', 1.0, 0.0, -1.0)
    models.apply_wrench('free::arm', (1.0, 0.0, 0.0), ZERO, 1e6, -1.0)
    sim.advance(10)
    {'clear': lambda: models.clear_efforts('free_joint'),
     'clear scoped': lambda: models.clear_efforts('free::free_joint'),
     'reset': sim.reset_world, 'reset simulation': sim.reset_simulation,
     'remove': lambda: models.remove('free')}[end]()
    if 'clear' in end:
        assert sim.world.pushes
        before = rate(models, 'free_joint')
        sim.advance(10)
        assert rate(models, 'free_joint') == pytest.approx(before, rel=1e-6)
        models.clear_wrenches('free::arm')
    assert not sim.world.pushes
    sim.advance(10)


@pytest.mark.parametrize('call, problem', [
    (lambda models: models.apply_wrench('box', ZERO, ZERO, 0, 1),
     "model box has no link '' (links: l)"),
    (lambda models: models.apply_wrench('cat::l', ZERO, ZERO, 0, 1), "no model 'cat' (models: "),
    (lambda models: models.apply_wrench('box::l', ZERO, ZERO, 0, 1, frame='cat'),
     "no model 'cat' (models: "),
    (lambda models: models.apply_wrench('box::l', (math.nan, 0, 0), ZERO, 0, 1), 'wrench: got '),
    (lambda models: models.apply_effort('fix', 1.0, 0, 1),
     "no movable joint 'fix' (movable joints: free::free_joint, "),
    (lambda models: models.apply_effort('free_joint', 1e9, 0, 1), 'effort: got ')])
def test_what_cannot_be_is_refused(models, sim, call, problem):
    assert refusal(call, models).startswith(problem)
    assert not sim.world.pushes


def test_joints_are_put_where_their_limits_allow(sim, models):
    models.set_joints('short', {'short_joint': 5.0, 'short::short_joint': 5.0, 'none': 1.0})
    models.set_joints('weak', {'weak_joint': -7.0})
    assert models.joint('short_joint')[0].joint_state('short_joint') == (1.0, 0.0)
    assert models.joint('weak_joint')[0].joint_state('weak_joint') == (-7.0, 0.0)
    assert models.state('short::arm').orientation[2:] == close(0.479425539, 0.877582562)
    sim.advance(10)
    assert models.state('short::arm').orientation[2:] == close(0.479425539, 0.877582562)
    assert 'finite' in refusal(models.set_joints, 'short', {'short_joint': math.inf})
