"""Figures of Gazebo 11.1 for the burger among things, and what simulate.py makes of the same.

The wheels turn there at the speeds of the command.
"""
import pytest

from img_recog.checks.check_jobs import simulate_parser
from img_recog.checks.simulation_run import SimulationRun
from img_recog_helpers import sdf
from img_recog_helpers.robots import burger

ROBOT = 'turtlebot3_burger::base_footprint'
MU = '<surface><friction><ode><mu>0.5</mu><mu2>0.5</mu2></ode></friction></surface>'


def box(pose, *size, mass=0.05, **more):
    return sdf.body('m', pose, sdf.box(*size), mass=mass, moments=mass / 600, **more)


def states(tmp_path, model, seconds, twist=''):
    """Return the states of all links after a time; twist: of the burger, if there is one."""
    world, urdf = tmp_path / 'w.sdf', tmp_path / 'burger.urdf'
    world.write_text(sdf.sdf(sdf.BUILT_IN, model))
    urdf.write_text(burger())
    lines = list(SimulationRun(simulate_parser().parse_args([
        str(world), '--until', str(seconds), '--every', str(seconds),
        *(['--urdf', str(urdf), '--twist', twist] if twist else [])])).lines())
    return next(line for line in lines[::-1] if 'links' in line)['links']


@pytest.mark.parametrize('model, seconds, link, x', [
    (box('0.25 0 0.05', 0.1, 0.1, 0.1, surface=MU), 4, 'm::l', 0.8605),
    (box('0.25 0 0.05', 0.1, 0.1, 0.1), 4, 'm::l', 0.8515),
    (box('1.29349 0 0.124408 0 -0.174533', 2, 1, 0.1, static=True), 5, ROBOT, 0.2974),
    (box('0.4 0 0.0015', 0.1, 1, 0.003, static=True), 5, ROBOT, 0.3364),
    (box('0.4 0 0.25', 0.1, 1, 0.5, static=True), 5, ROBOT, 0.3120)])
def test_what_the_burger_pushes_and_what_stops_it(model, seconds, link, x, tmp_path):
    found = states(tmp_path, model, seconds, '0.2,0')
    assert found[link][0] == pytest.approx(x, rel=0.02, abs=0.005)


def test_a_box_that_fell_lies_flat_on_the_floor(tmp_path):
    # from 1.9 m above it
    state = states(tmp_path, box('0 0 2', 0.2, 0.2, 0.2, mass=1), 1)['m::l']
    assert state[2:6] == pytest.approx([0.1, 0, 0, 0], abs=0.003)
