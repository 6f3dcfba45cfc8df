"""A laser scanner that casts rays into the world."""
import numpy as np
import pybullet

from img_recog.simulation.body import rotation_matrix
from img_recog.simulation.robot import COLLISION_GROUP, Robot
from img_recog.simulation.sensor import Sensor
from img_recog.simulation.settings import ScanSettings, SimulationError
from img_recog.simulation.solids import Solids


class LaserScanner(Sensor):
    """Measures all ranges at one time from the origin of its frame; does not see its own robot."""

    def __init__(self, robot: Robot, settings: ScanSettings, noise: np.random.RandomState):
        """Mount the scanner on a link of `robot`.

        Raises SimulationError when the robot has no such link, or the shortest range is not less
        than the longest.
        """
        if not settings.scan_range_min < settings.scan_range_max:
            raise SimulationError('scan_range_min: got {:g} m, expected less than scan_range_max, '
                                  '{:g} m'.format(settings.scan_range_min,
                                                  settings.scan_range_max))
        robot.check_frame('scan_frame', settings.scan_frame)
        self._robot, self._settings, self._noise = robot, settings, noise
        self._solids = Solids(robot.physics_client_id, robot.body_id)
        angles = np.linspace(settings.scan_angle_min, settings.scan_angle_max,
                             settings.scan_samples)
        self._directions = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])

    def read(self) -> np.ndarray:
        """Return the ranges, float64 of shape (scan_samples,), in m, +inf where nothing is hit.

        Noise is added to hits; they stay from scan_range_min to scan_range_max.
        """
        settings = self._settings
        motion = self._robot.motion(settings.scan_frame)
        rotation = rotation_matrix(motion.orientation)
        directions = (rotation @ self._directions).T
        ranges = self._solids.distances(motion.position, directions, settings.scan_range_max)
        if ranges is None:
            ranges = self._cast(motion.position, directions)
        missed = ranges > settings.scan_range_max
        # drawn for every ray, so that the noise does not depend on what is hit
        ranges += self._noise.normal(0.0, settings.scan_noise, len(ranges))
        ranges = np.clip(ranges, settings.scan_range_min, settings.scan_range_max)
        return np.where(missed, np.inf, ranges)

    def _cast(self, start: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return what Solids.distances does, by PyBullet's rays, for shapes of all kinds."""
        longest = self._settings.scan_range_max
        ends = start + longest * directions
        hits = pybullet.rayTestBatch(
            np.broadcast_to(start, ends.shape).tolist(), ends.tolist(),
            collisionFilterMask=~COLLISION_GROUP, numThreads=0,
            physicsClientId=self._robot.physics_client_id)
        return np.array([hit[2] * longest if hit[0] >= 0 else np.inf for hit in hits])
