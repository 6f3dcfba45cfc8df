"""A laser scanner that casts rays into the world."""
from typing import List, Optional, Sequence

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.simulation.bodies.robot import Robot
from img_recog.simulation.bodies.solids import Bundles, Solids
from img_recog.simulation.sensors.sensor import Sensor
from img_recog.simulation.settings import ScanSettings, SimulationError

_MAX_OWN_SHAPES = 20        # of its own robot, that a ray may cross one after the other
_PAST_M = 1e-3              # a ray goes on so far behind the surface of such a shape


class LaserScanner(Sensor):
    """Measures all ranges at one time from the origin of its frame; does not see its own robot."""

    def __init__(self, robot: Robot, settings: ScanSettings, noise: np.random.RandomState,
                 solids: Solids):
        """Mount the scanner on a link of `robot`.

        solids: of the physics client; scanners that share it can be read together.
        Raises SimulationError when the robot has no such link, or the shortest range is not less
        than the longest.
        """
        if not settings.scan_range_min < settings.scan_range_max:
            raise SimulationError('scan_range_min: got {:g} m, expected less than scan_range_max, '
                                  '{:g} m'.format(settings.scan_range_min,
                                                  settings.scan_range_max))
        robot.check_frame('scan_frame', settings.scan_frame)
        self._robot, self._settings, self._noise = robot, settings, noise
        self.solids = solids
        angles = np.linspace(settings.scan_angle_min, settings.scan_angle_max,
                             settings.scan_samples)
        self._directions = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])

    def read(self) -> np.ndarray:
        """Return the ranges, float64 of shape (scan_samples,), in m, +inf where nothing is hit.

        Noise is added to hits; they stay from scan_range_min to scan_range_max.
        """
        return read_together([self])[0]

    @property
    def samples(self) -> int:
        """The number of ranges."""
        return self._settings.scan_samples

    def rays(self) -> Bundles:
        """Return the rays from where the scanner is now, a bundle."""
        motion = self._robot.motion(self._settings.scan_frame)
        directions = (rotations.matrix(motion.orientation) @ self._directions).T
        return Bundles(motion.position[None], directions[None],
                       np.array([self._settings.scan_range_max]),
                       np.array([self._robot.body_id]))

    def ranges(self, distances: np.ndarray) -> np.ndarray:
        """Return what the scanner measures where its rays go so far, (scan_samples,)."""
        settings = self._settings
        missed = distances > settings.scan_range_max
        # drawn for every ray, so that the noise does not depend on what is hit
        measured = distances + self._noise.normal(0.0, settings.scan_noise, len(distances))
        measured = np.clip(measured, settings.scan_range_min, settings.scan_range_max)
        return np.where(missed, np.inf, measured)

    def cast(self, bundle: Bundles) -> np.ndarray:
        """Return what Solids.distances does, by PyBullet's rays, for shapes of all kinds."""
        longest = self._settings.scan_range_max
        directions = bundle.directions[0]
        ends = bundle.starts[0] + longest * directions
        passed = np.zeros(len(directions))      # how far each ray has come
        distances = np.full(len(directions), np.inf)
        rays = np.arange(len(directions))
        for _ in range(_MAX_OWN_SHAPES):
            starts = bundle.starts[0] + passed[rays, None] * directions[rays]
            hits = pybullet.rayTestBatch(
                starts.tolist(), ends[rays].tolist(), numThreads=0,
                physicsClientId=self._robot.physics_client_id)
            bodies = np.array([hit[0] for hit in hits])
            passed[rays] += (longest - passed[rays]) * [hit[2] for hit in hits]
            others = rays[(bodies >= 0) & (bodies != self._robot.body_id)]
            distances[others] = passed[others]
            rays = rays[bodies == self._robot.body_id]
            passed[rays] += _PAST_M
            rays = rays[passed[rays] < longest]
            if not len(rays):
                break
        return distances


def read_together(scanners: Sequence[LaserScanner]) -> List[np.ndarray]:
    """Return what each of some scanners of a physics client measures now."""
    bundles = [scanner.rays() for scanner in scanners]
    distances: List[Optional[np.ndarray]] = [None] * len(scanners)
    for samples in {scanner.samples for scanner in scanners}:
        numbers = [number for number, scanner in enumerate(scanners)
                   if scanner.samples == samples]
        found = scanners[0].solids.distances(Bundles(
            *map(np.concatenate, zip(*(bundles[number] for number in numbers)))))
        if found is not None:
            for number, row in zip(numbers, found):
                distances[number] = row
    return [scanner.ranges(scanner.cast(bundle) if found is None else found)
            for scanner, bundle, found in zip(scanners, bundles, distances)]
