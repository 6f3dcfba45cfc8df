"""What sinks into a floor, rests and bounces, against Gazebo 11 (recorded figures)."""

import pytest

from img_recog_helpers import sdf

BALL, BOX = sdf.ball(0.1), sdf.box(0.2, 0.2, 0.2)
CYLINDER = '<cylinder><radius>0.1</radius><length>0.2</length></cylinder>'


def surface(contact='', bounce=''):
    if bounce:
        bounce = ('<bounce><restitution_coefficient>{}</restitution_coefficient><threshold>0.01'
                  '</threshold></bounce>').format(bounce)
    ode = ''.join('<{0}>{1}</{0}>'.format(*each.split('=')) for each in contact.split())
    return '<surface><contact><ode>{}</ode></contact>{}</surface>'.format(ode, bounce)


def heights(shape, height, mass, contact, times, bounce=''):
    """Return the heights, in m, of a body above a floor at some times."""
    simulator = sdf.simulated(
        sdf.body('floor', '', '<plane/>', static=True, surface=surface('', bounce)),
        sdf.body('b', '0 0 {}'.format(height), shape, mass=mass, moments=0.004 * mass,
                 surface=surface(contact, bounce)))
    return [sdf.figures(simulator, time - before).links()['b::l'][2]
            for before, time in zip([0, *times], times)]


@pytest.mark.parametrize('shape, mass, contact, found', [
    (BALL, 1, 'kp=1000 kd=1', {0.1: 0.0568, 0.5: -0.5554, 1: -1.4326, 3: -2.8921}),
    (BALL, 1, 'kp=10000 kd=1', {0.1: 0.0757, 0.5: 0.0214, 3: 0.0192}),
    (BALL, 1, 'kp=10000 kd=100', {0.1: 0.0951, 0.5: 0.0914, 3: 0.0913}),
    (BALL, 1, 'kp=100000 kd=1', {0.5: 0.0991}), (BALL, 1, 'kp=1000000 kd=1', {0.5: 0.1}),
    (BALL, 1, 'kp=1000 kd=1 max_vel=100', {0.1: 0.0819, 0.5: 0.0858, 1: 0.0924, 3: 0.0905}),
    (BALL, 1, 'kp=1000 kd=100 max_vel=100', {0.1: 0.0940, 0.5: 0.0903}),
    # where it rests; PyBullet finds one corner of a box on a plane in a step, so it gets there
    # in another way
    (BOX, 10, 'kp=10000 kd=100', {3: 0.0454}), (BOX, 10, 'kp=100000 kd=1', {3: 0.0941}),
    (BOX, 10, 'kp=10000 kd=100 max_vel=100', {3: 0.0976}),
    (CYLINDER, 5, 'kp=30000 kd=30', {3: 0.0917})])
def test_how_deep_a_body_sinks(shape, mass, contact, found):
    measured = heights(shape, 0.1, mass, contact, list(found))
    for time, z, expected in zip(found, measured, found.values()):
        assert z == pytest.approx(expected, abs=max(0.001, 0.012 * abs(0.1 - expected))), time


def test_a_contact_without_stiffness_holds_nothing():
    """In Gazebo, its body is nowhere then."""
    assert heights(BALL, 0.1, 1, 'kp=0 kd=-1 max_vel=0', [0.5])[0] < -0.5


@pytest.mark.parametrize('contact, bounce, found', [
    ('max_vel=100', 0.9, {0.5: 0.277, 0.8: 0.8923, 1: 0.8126}),
    ('max_vel=100', 1, {0.5: 0.2983, 0.8: 1.0465, 1: 1.0553}),
    # ODE lets out what is deep at once
    ('max_vel=100', '', {0.5: 0.2443, 0.8: 0.6549, 1: 0.4387}),
    ('max_vel=100', 0.3, {0.5: 0.2443, 0.8: 0.6549, 1: 0.4387}),
    ('', 0.9, {0.5: 0.1, 0.8: 0.1}), ('', '', {0.5: 0.1, 0.8: 0.1})])
def test_how_high_a_ball_comes_back(contact, bounce, found):
    measured = heights(BALL, 1.1, 1, contact, list(found), bounce)
    assert measured == pytest.approx(list(found.values()), abs=0.015)
