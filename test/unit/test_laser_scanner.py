"""The scan against the analytic geometry of the world."""
import math

import numpy as np
import pytest
from robots import simulator

from img_recog.simulation.settings import ScanSettings, SensorSettings, SimulationError

ANGLES = np.linspace(0.0, 6.28319, 360)


def scan(sim):
    """Return the first scan and where its origin is in the world."""
    reading = next(each for each in sim.advance(200) if each.sensor == 'scan')
    return reading.value, sim.vehicles[0].robot.motion('base_scan')


def ray_to_circle(origin, direction, centre, radius):
    offset = np.subtract(centre, origin)
    along = offset @ direction
    square = radius ** 2 - (offset @ offset - along ** 2)
    return along - math.sqrt(square) if square >= 0 and along > 0 else math.inf


def ray_inside_hexagon(origin, direction, apothem):
    """Return the distance to a hexagon around the world's origin, corners on the x axis."""
    normals = [(math.cos(a), math.sin(a)) for a in np.radians(range(30, 390, 60))]
    return min((apothem - np.dot(normal, origin)) / np.dot(normal, direction)
               for normal in normals if np.dot(normal, direction) > 1e-9)


def geometric_model(origin, angles):
    """Return the ranges in turtlebot3_world from inside the wall, where no prism stands free."""
    ranges = []
    for angle in angles:
        direction = np.array([math.cos(angle), math.sin(angle)])
        hits = [ray_to_circle(origin, direction, (x, y), 0.15)
                for x in (-1.1, 0, 1.1) for y in (-1.1, 0, 1.1)]
        hits.append(ray_inside_hexagon(origin, direction, 2.540))
        # a prism reaches through the wall where its corner does
        for centre, corner in (((3.5, 0), 1.173), *(((x, y), 0.807) for x in (-1.8, 1.8)
                                                    for y in (-2.7, 2.7))):
            hits.append(ray_to_hexagon(origin, direction, centre, corner))
        nearest = min(hits)
        ranges.append(nearest if nearest <= 3.5 else math.inf)
    return np.array(ranges)


def ray_to_hexagon(origin, direction, centre, corner):
    """Return the distance to a hexagon from outside (slab by slab)."""
    enter, leave, apothem = -math.inf, math.inf, corner * math.sqrt(3) / 2
    for angle in np.radians((30, 90, 150)):
        normal = np.array([math.cos(angle), math.sin(angle)])
        speed, offset = normal @ direction, normal @ np.subtract(centre, origin)
        if abs(speed) < 1e-12:
            if abs(offset) > apothem:
                return math.inf
            continue
        near, far = sorted(((offset - apothem) / speed, (offset + apothem) / speed))
        enter, leave = max(enter, near), min(leave, far)
    return enter if 0 < enter <= leave else math.inf


@pytest.mark.parametrize('x, y, yaw', [(-2.0, -0.5, 0.0), (0.5, 0.4, 1.0), (1.9, -0.6, -2.5)])
def test_scan_of_the_world_is_its_geometry(x, y, yaw):
    exact = ScanSettings(scan_noise=0.0)
    ranges, motion = scan(simulator('turtlebot3_world', x, y, yaw, scan=exact))
    qx, qy, qz, qw = motion.orientation
    heading = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
    model = geometric_model(motion.position[:2], heading + ANGLES)
    both = np.isfinite(ranges) & np.isfinite(model)
    assert np.count_nonzero(both) > 300
    # a ray that grazes the rim of a post may see it or what is behind it
    grazing = np.isfinite(ranges) != np.isfinite(model)
    grazing[both] = np.abs(ranges[both] - model[both]) > 0.03
    assert np.count_nonzero(grazing) <= 2


def test_scan_in_the_open_is_infinite_and_blind_to_the_robot():
    ranges, _ = scan(simulator('empty'))
    assert ranges.shape == (360,)
    assert np.all(np.isposinf(ranges))


def test_noise_is_seeded_and_as_large_as_it_says():
    exact, _ = scan(simulator('turtlebot3_world', scan=ScanSettings(scan_noise=0.0), x=0.5, y=0.5))
    noisy, _ = scan(simulator('turtlebot3_world', x=0.5, y=0.5))
    again, _ = scan(simulator('turtlebot3_world', x=0.5, y=0.5))
    other, _ = scan(simulator('turtlebot3_world', x=0.5, y=0.5, sensors=SensorSettings(seed=1)))
    hit = np.isfinite(exact)
    assert np.std((noisy - exact)[hit]) == pytest.approx(0.01, rel=0.2)
    assert np.array_equal(noisy, again)
    assert not np.array_equal(noisy, other)


def test_never_below_range_min():
    # 0.02 m between the robot's side and a post: nearer than the scanner sees
    ranges, _ = scan(simulator('turtlebot3_world', x=0.032, y=0.25))
    assert ranges.min() == 0.12


@pytest.mark.parametrize('settings, words', [
    (ScanSettings(scan_frame='lidar'), 'no link lidar (has base_footprint'),
    (ScanSettings(scan_range_min=4.0), 'scan_range_min: got 4 m')])
def test_refusals(settings, words):
    with pytest.raises(SimulationError) as error:
        simulator(scan=settings)
    assert words in str(error.value)
