"""The scan against the analytic geometry of the world."""
import math

import numpy as np
import pytest

from img_recog.simulation.simulation_settings import NoiseSettings
from img_recog_helpers import sdf, turtlebot3_world
from img_recog_helpers.robots import assemble, burgers

ANGLES = np.linspace(0.0, 6.28319, 360)


def scan(sim):
    """Return the first scan and where its origin is in the world."""
    reading = next(each for each in sim.advance(200) if each.sensor == 'scan')
    return reading.value, sim.robots[0].body.motion('base_scan')


@pytest.mark.parametrize('x, y, yaw', [(-2.0, -0.5, 0.0), (0.5, 0.4, 1.0), (1.9, -0.6, -2.5)])
def test_scan_of_the_world_is_its_geometry(x, y, yaw):
    exact = burgers('scan', scan_noise=0.0)
    ranges, motion = scan(assemble('turtlebot3_world', x, y, yaw, scan=exact))
    model = turtlebot3_world.ranges(motion.position[:2], motion.yaw + ANGLES, 3.5)
    both = np.isfinite(ranges) & np.isfinite(model)
    assert np.count_nonzero(both) > 300
    # a ray that grazes the rim of a post may see it or what is behind it
    grazing = np.isfinite(ranges) != np.isfinite(model)
    grazing[both] = np.abs(ranges[both] - model[both]) > 0.03
    assert np.count_nonzero(grazing) <= 2


def test_scan_of_a_wall_of_known_distance():
    wall = sdf.body('wall', '1.55 0 0.5', sdf.box(0.1, 4, 1), static=True)
    sim = assemble(sdf.sdf(sdf.BUILT_IN, wall), x=0.032, scan=burgers('scan', scan_noise=0.0))
    ranges, motion = scan(sim)
    assert motion.position[:2] == pytest.approx([0.0, 0.0], abs=1e-3)
    hit = np.cos(ANGLES) > math.cos(math.atan2(1.9, 1.5))       # within the wall's ends
    assert np.count_nonzero(hit) > 100
    assert ranges[hit] == pytest.approx(1.5 / np.cos(ANGLES[hit]), abs=0.02)
    assert np.all(np.isposinf(ranges[np.cos(ANGLES) < 0]))


def test_scan_in_the_open_is_infinite_and_blind_to_the_robot():
    ranges, _ = scan(assemble('empty'))
    assert ranges.shape == (360,)
    assert np.all(np.isposinf(ranges))


def test_noise_is_seeded_and_as_large_as_it_says():
    exact, _ = scan(assemble('turtlebot3_world', x=0.5, y=0.5,
                             scan=burgers('scan', scan_noise=0.0)))
    noisy, _ = scan(assemble('turtlebot3_world', x=0.5, y=0.5))
    again, _ = scan(assemble('turtlebot3_world', x=0.5, y=0.5))
    other, _ = scan(assemble('turtlebot3_world', x=0.5, y=0.5, noise=NoiseSettings(seed=1)))
    hit = np.isfinite(exact)
    assert np.std((noisy - exact)[hit]) == pytest.approx(0.01, rel=0.2)
    assert np.array_equal(noisy, again)
    assert not np.array_equal(noisy, other)


def test_never_below_range_min():
    # 0.02 m between the robot's side and a post: nearer than the scanner sees
    ranges, _ = scan(assemble('turtlebot3_world', x=0.032, y=0.25))
    assert ranges.min() == 0.12
