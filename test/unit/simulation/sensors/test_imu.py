"""The inertial unit: at rest, driving off, turning, and moved by a reset."""
import numpy as np
import pytest

from img_recog_helpers.robots import assemble, burgers

QUIET = burgers('imu', gyro_noise=0.0, accel_noise=0.0)


def measure(sim, steps):
    return [each.value for each in sim.advance(steps) if each.sensor == 'imu']


def test_at_rest_it_feels_gravity_upwards():
    sim = assemble(imu=QUIET)
    sim.advance(1000)
    values = measure(sim, 1000)
    assert len(values) == 200
    force = np.mean([value.linear_acceleration for value in values], axis=0)
    # the burger leans back on its caster by a third of a degree
    assert np.linalg.norm(force) == pytest.approx(9.8, abs=0.01)
    assert force == pytest.approx([0, 0, 9.8], abs=0.1)
    assert np.abs([value.angular_velocity for value in values]).max() < 1e-3


def test_noise_is_as_large_as_it_says():
    sim = assemble()
    sim.advance(1000)
    values = measure(sim, 5000)
    assert np.std([v.angular_velocity for v in values]) == pytest.approx(2e-4, rel=0.1)
    assert np.std([v.linear_acceleration[1] for v in values]) == pytest.approx(1.7e-2, rel=0.15)


def test_driving_off_pushes_forward():
    sim = assemble(imu=QUIET)
    sim.advance(1000)
    sim.robots[0].command(0.4, 0.0)
    force = np.mean([value.linear_acceleration for value in measure(sim, 300)], axis=0)
    assert force[0] == pytest.approx(sim.robots[0].body.motion().linear[0] / 0.3, rel=0.1)
    assert force[0] > 0.5


def test_a_reset_is_not_an_acceleration():
    sim = assemble(imu=QUIET)
    sim.robots[0].command(1.0, 0.0)
    sim.advance(1000)
    sim.reset_world()
    first = measure(sim, 5)[0]
    assert np.linalg.norm(np.subtract(first.linear_acceleration, [0, 0, 9.8])) < 0.5
