"""Hinged cylinders collide like in Gazebo: drums, rollers, a turntable, wheels at rails.

The figures were measured in Gazebo 11.1.
"""
import math

import pybullet
import pytest

from img_recog.checks.check_jobs import simulate_parser
from img_recog.checks.simulation_run import SimulationRun
from img_recog_helpers import sdf

UPRIGHT, ALONG_Y = '0 0 0', '-1.5707963267948966 0 0'
HINGE = ('<joint name="{0}_hinge" type="revolute"><parent>{1}</parent><child>{0}</child><axis>'
         '<xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis></joint>')
LIDAR = ('<sensor name="lidar" type="ray"><ray><scan><horizontal><samples>3</samples>'
         '<min_angle>-0.05</min_angle><max_angle>0.05</max_angle></horizontal></scan><range>'
         '<min>0.05</min><max>10</max></range></ray><update_rate>10</update_rate></sensor>')


def roller(name, place, size, mass=1, parent='world', rpy=ALONG_Y, surface=''):
    """Return a solid cylinder and its hinge.

    Args:
        place: Position of the cylinder, three numbers as text.
        size: Radius and length in m.
    """
    radius, length = size
    across = mass * (3 * radius ** 2 + length ** 2) / 12
    return sdf.link(
        name, '{} {}'.format(place, rpy), '<cylinder><radius>{}</radius><length>{}</length>'
        '</cylinder>'.format(*size), mass, (across, across, mass * radius ** 2 / 2),
        surface) + HINGE.format(name, parent)


def box(name, pose, x, y, z, mass=1, surface=''):
    """Return a solid box that can move."""
    return sdf.body(name, pose, sdf.box(x, y, z), mass=mass, surface=surface, moments=tuple(
        mass * (a ** 2 + b ** 2) / 12 for a, b in ((y, z), (x, z), (x, y))))


def lines(tmp_path, models, seconds, drives=()):
    """Return the lines that simulate.py prints for a world of these models.

    Args:
        drives: Motors, each as MODEL::JOINT=VELOCITY:TORQUE.
    """
    path = tmp_path / 'w.sdf'
    path.write_text(sdf.sdf(sdf.BUILT_IN, *models))
    return list(SimulationRun(simulate_parser().parse_args([
        str(path), '--until', str(seconds), '--every', str(seconds),
        *(word for drive in drives for word in ('--drive', drive))])).lines())


def links(tmp_path, *more):
    """Return the states of the links at the end of `lines`."""
    return [line for line in lines(tmp_path, *more) if 'links' in line][-1]['links']


def angles(tmp_path, *more):
    """Return the angles of the joints at the end of `lines`."""
    return {name: values[0] for name, values in [
        line for line in lines(tmp_path, *more) if 'joints' in line][-1]['joints'].items()}


@pytest.mark.parametrize('radius, ranges', [
    (0.15, [0.8573, 0.85, 0.8573]), (0.03, [math.inf, 0.97, math.inf])])
def test_a_lidar_measures_the_distance_of_a_drum(radius, ranges, tmp_path):
    models = [sdf.model('s', sdf.link(inside=LIDAR), pose='-1 0 0.5', static=True),
              sdf.model('m', sdf.link('base', '0 0 0.05', sdf.box(0.3, 0.3, 0.1), 20, 0.2),
                        roller('drum', '0 0 0.51', (radius, 0.8), 2, 'base', UPRIGHT))]
    found, = (line['ranges'] for line in lines(tmp_path, models, 0.5) if 'ray' in line)
    assert found == pytest.approx(ranges, abs=0.001)


@pytest.mark.parametrize('radius, height', [(0.1, 0.55), (0.04, 0.49)])
@pytest.mark.parametrize('drives', [(), ['m::roller_hinge=0:100']])
def test_a_box_lies_on_a_roller(radius, height, drives, tmp_path):
    found = links(tmp_path, [
        sdf.model('m', sdf.link('base', '0 0 0.1', sdf.box(0.5, 0.5, 0.2), 50, 2),
                  roller('roller', '0 0 0.4', (radius, 0.4), 0.5, 'base')),
        box('box', '0 0 {}'.format(radius + 0.45), 0.2, 0.2, 0.1, 0.2)], 0.75, drives)['box::l']
    assert found[:3] == pytest.approx([0, 0, height], abs=0.002)


@pytest.mark.parametrize('radius', [0.05, 0.1])
def test_a_conveyor_moves_a_box(radius, tmp_path):
    found = links(tmp_path, [
        sdf.model('m', *(roller('r{}'.format(number), '{} 0 0.4'.format(number / 4),
                                (radius, 0.4)) for number in range(3))),
        box('box', '0.15 0 {}'.format(radius + 0.45), 0.5, 0.2, 0.1, 2)], 1, [
            'm::r{}_hinge={}:100'.format(number, 0.2 / radius) for number in range(3)])['box::l']
    assert found[0] - 0.15 == pytest.approx(0.1981, rel=0.02)
    assert found[2] == pytest.approx(radius + 0.45, abs=0.002)


@pytest.mark.parametrize('speed, start, place, yaw', [
    (0.5, 0.2, (0.1086, 0.1683), 0.995), (1, 0.3, (-0.1215, 0.2761), 1.971)])
def test_a_cube_turns_with_a_turntable(speed, start, place, yaw, tmp_path):
    found = links(tmp_path, [
        sdf.model('m', roller('table', '0 0 0.3', (0.4, 0.05), 5, rpy=UPRIGHT)),
        box('box', '{} 0 0.375'.format(start), 0.1, 0.1, 0.1)], 2, [
            'm::table_hinge={}:100'.format(speed)])['box::l']
    assert found[:3] == pytest.approx([*place, 0.375], rel=0.02, abs=0.005)
    assert 2 * math.atan2(found[5], found[6]) == pytest.approx(yaw, rel=0.02)


# a rail that all wheels meet, and posts narrower than a wheel, which meet its middle
RAIL = [sdf.body('rail', '0.3 0 {}', sdf.box(0.02, 1, '{}'), static=True)]
POSTS = [sdf.body('left_post', '0.3 0.1 {}', sdf.box(0.02, 0.01, '{}'), static=True),
         sdf.body('right_post', '0.3 -0.1 {}', sdf.box(0.02, 0.01, '{}'), static=True)]


def cart():
    """Return a cart on four wheels with a radius of 5 cm."""
    return sdf.model(
        'm', sdf.link('base', '0 0 0.07', sdf.box(0.3, 0.1, 0.04), 2, 0.02),
        *(roller(wheel, '{} 0.05'.format(place), (0.05, 0.03), 0.3, 'base') for wheel, place in (
            ('left', '0 0.1'), ('right', '0 -0.1'), ('front_left', '0.12 0.1'),
            ('front_right', '0.12 -0.1'))))


@pytest.mark.parametrize('obstacle, height, x', [
    (RAIL, 0.015, 0.2543), (RAIL, 0.005, 0.3743), (POSTS, 0.015, 0.2543),
    (POSTS, 0.005, 0.3749)])
def test_wheels_roll_over_low_obstacles_and_stop_at_high_ones(obstacle, height, x, tmp_path):
    found = links(tmp_path, [cart(), *(
        each.format(height / 2, height) for each in obstacle)], 2, [
            'm::{}_hinge=4:0.15'.format(side) for side in ('left', 'right')])['m::base']
    assert found[:3] == pytest.approx([x, 0, 0.07], rel=0.02, abs=0.005)


@pytest.mark.parametrize('shift', [0, 0.1])
def test_a_roller_turns_another_one(shift, tmp_path):
    found = angles(tmp_path, [
        sdf.model('m', roller('roller', '0 0 0.4', (0.1, 0.4))),
        sdf.model('n', roller('other', '0.199 {} 0.4'.format(shift), (0.1, 0.4)))], 2, [
            'm::roller_hinge=3:0.5'])
    assert found == pytest.approx({'m::roller_hinge': 5.912, 'n::other_hinge': -5.907}, rel=0.02)


@pytest.mark.parametrize('drives, turned', [
    (['m::a_hinge=4:10', 'm::b_hinge=4:10'], (3.999, 4.001, -1.972)),
    (['n::left_hinge=4:10', 'n::right_hinge=4:10'], (-8.478, -8.454, 3.999))])
def test_wheels_lie_between_two_rollers_and_turn_with_them(drives, turned, tmp_path):
    models = [sdf.model('m', roller('a', '0 0 0.3', (0.05, 0.6)),
                        roller('b', '0.15 0 0.3', (0.05, 0.6))),
              sdf.model('n', sdf.link('base', '0.075 0 0.4', sdf.box(0.1, 0.1, 0.04), 2, 0.02),
                        *(roller(name, '0.075 {} 0.4309038'.format(y), (0.1, 0.04), 1, 'base')
                          for name, y in (('left', 0.15), ('right', -0.15))))]
    line = [each for each in lines(tmp_path, models, 1, drives) if 'links' in each][-1]
    assert [line['joints'][name][0] for name in (
        'm::a_hinge', 'm::b_hinge', 'n::left_hinge')] == pytest.approx(turned, rel=0.02)
    assert line['links']['n::left'][2] == pytest.approx(0.4299, abs=0.002)


@pytest.mark.parametrize('collides, distance, other', [('', 0.15, 0), (1, 0.199, -0.523)])
def test_rollers_of_a_model_touch_one_another_if_it_collides_with_itself(
        collides, distance, other, tmp_path):
    found = angles(tmp_path, [sdf.model(
        'm', collides and '<self_collide>1</self_collide>', roller('a', '0 0 0.3', (0.1, 0.4)),
        roller('b', '{} 0 0.3'.format(distance), (0.1, 0.4)))], 0.5, ['m::a_hinge=1:5'])
    assert found == pytest.approx({'m::a_hinge': 0.504, 'm::b_hinge': other}, rel=0.05, abs=0.01)


def test_a_wheel_on_a_sill_touches_it_with_both_edges():
    wheels = [roller(name, '0 {} 0.06'.format(y), (0.05, 0.04), 0.2, 'base')
              for name, y in (('left', 0.2), ('right', -0.2))]
    simulator = sdf.simulated(
        sdf.body('sill', '0 0 0.005', sdf.box(0.9, 0.9, 0.01), static=True),
        sdf.model('robot', sdf.link('base', '0 0 0.06', sdf.box(0.3, 0.2, 0.04), 4, 0.05),
                  *wheels, sdf.link('caster', '0.12 0 0.03', sdf.ball(0.02), 0.1, 0.001),
                  '<joint name="held" type="fixed"><parent>base</parent><child>caster</child>'
                  '</joint>'))
    simulator.advance(500)
    body = simulator.world.bodies[1]
    touched = {round(contact[5][1], 2) for contact in pybullet.getContactPoints(
        bodyA=body.body_id, **body.client)}
    assert {-0.22, -0.18, 0.18, 0.22} <= touched
