"""Robots on four wheels that turn slowly, against the same robots in Gazebo 11 (recorded figures).
"""
import math

import pytest

from img_recog import rotations
from img_recog_helpers import sdf

_WHEELS = {'lf': (1, 1), 'lb': (-1, 1), 'rf': (1, -1), 'rb': (-1, -1)}
ISOTROPIC = ''
DIRECTED = ('<surface><friction><ode><mu>{0}</mu><mu2>{0}</mu2><fdir1>{1}</fdir1></ode>'
            '</friction><contact><ode><kp>1e7</kp><kd>1</kd></ode></contact></surface>').format
LEVEL = '1 0 0'
LONG = 0.12, 0.1, 0.06, 4, 0.4
SQUARE = 0.2, 0.2, 0.1, 5, 0.5
HINGE = ('<joint name="j_{0}" type="revolute"><parent>base</parent><child>{0}</child><axis>'
         '<xyz>0 0 1</xyz></axis></joint>')


def four_wheeled(heading, height, half_base, half_track, radius, base_mass, wheel_mass, surface,
                 **options):
    """Return a simulator with a robot r at a height above the floor, in m."""
    disc = '<cylinder><radius>{}</radius><length>0.04</length></cylinder>'.format(radius)
    across = wheel_mass * (3 * radius ** 2 + 0.04 ** 2) / 12
    parts = [sdf.link('base', '0 0 {}'.format(radius + 0.02),
                      sdf.box(2 * half_base, 1.4 * half_track, radius / 2), mass=base_mass,
                      moments=tuple(base_mass * share for share in (0.01, 0.02, 0.025)))]
    for name, (front, left) in _WHEELS.items():
        parts += [sdf.link(
            name, '{} {} {} {!r} 0 0'.format(front * half_base, left * half_track, radius,
                                             -math.pi / 2),
            disc, mass=wheel_mass, moments=(across, across, wheel_mass * radius ** 2 / 2),
            surface=surface), HINGE.format(name)]
    return sdf.simulated(sdf.BUILT_IN, sdf.model(
        'r', *parts, pose='0 0 {} 0 0 {}'.format(height, heading)), **options)


def turned(heading, *robot, velocity):
    """Return the yaw in rad of a robot after 3 s; velocity: of its wheels, in rad/s."""
    simulator = four_wheeled(heading, 0, *robot)
    values = sdf.figures(simulator, 0.0)
    for name, (_, left) in _WHEELS.items():
        values.set_motor('r::j_' + name, -left * velocity, 10.0)
    yaw = rotations.yaw(sdf.figures(simulator, 3.0).links()['r::base'][3:7])
    return math.remainder(yaw - heading, 2 * math.pi)


@pytest.mark.parametrize('heading, yaw', [(0.3, 0.2603), (0.785, 0.3195)])
def test_a_robot_turns_at_a_heading_though_friction_is_a_pyramid(heading, yaw):
    """At heading 0, Gazebo has 0.1385 rad, and 0.9 rad at 3 rad/s; here, it does not turn."""
    found = turned(heading, *LONG, ISOTROPIC, velocity=0.5)
    assert yaw / 2 < found < 2 * yaw


@pytest.mark.parametrize('velocity, yaw', [(0.5, 0.005), (3, 0.0817)])
def test_light_wheels_lean_so_a_square_robot_stays(velocity, yaw):
    """In Gazebo, two wheels on their inner edges bear it; rigid ones turn on their outer edges."""
    assert turned(0, *SQUARE, ISOTROPIC, velocity=velocity) == pytest.approx(yaw, abs=0.07)


@pytest.mark.parametrize('heading', [0, 0.3, 0.785])
@pytest.mark.parametrize('robot, velocity, yaw', [
    ((0.1, 0.15, 0.08, 12, 0.6, DIRECTED(0.5, LEVEL)), 0.9, 1.2551),
    # too long to turn
    ((*LONG, DIRECTED(0.6, LEVEL)), 0.5, 0.0033)])
def test_with_a_direction_of_friction_the_heading_makes_no_difference(
        robot, velocity, yaw, heading):
    assert turned(heading, *robot, velocity=velocity) == pytest.approx(yaw, rel=0.02, abs=0.01)


@pytest.mark.parametrize('direction, x', [
    (LEVEL, 0.1694), ('2 0 0', 0.0844), ('1 1 0', 0.2204), ('1 -1 0', 0.1184)])
def test_a_direction_that_leans_presses_a_locked_wheel_onto_the_floor_or_lifts_it(direction, x):
    """The friction along it has a vertical part, which is a load or takes it off."""
    simulator = four_wheeled(0, 0, *LONG, DIRECTED(0.3, direction),
                             velocities={'r': ((1.0, 0, 0), (0, 0, 0))})
    values = sdf.figures(simulator, 0.0)
    for name in _WHEELS:
        values.set_motor('r::j_' + name, 0.0, 1000.0)
    assert sdf.figures(simulator, 0.5).links()['r::base'][0] == pytest.approx(x, rel=0.05)


@pytest.mark.parametrize('surface', [ISOTROPIC, DIRECTED(0.5, LEVEL)])
def test_a_robot_that_falls_onto_its_wheels_does_not_bounce(surface):
    simulator = four_wheeled(0, 0.03, *LONG, surface)
    body = simulator.world.scenery[0]
    heights = []
    for _ in range(500):
        simulator.advance(1)
        heights.append(body.pose().position[2])
    landed = next(step for step, height in enumerate(heights) if height < heights[-1] + 1e-5)
    assert max(heights[landed:]) < heights[-1] + 1e-4
