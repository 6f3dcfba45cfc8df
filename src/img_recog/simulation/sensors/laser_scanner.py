"""A laser scanner, by default an LDS-01 like that of turtlebot3_gazebo."""
from dataclasses import dataclass

import numpy as np

from img_recog.settings import Settings, above, any_value, at_least, between, not_empty, setting
from img_recog.simulation.descriptions.gazebo_tags import (INTEGER, NAME, NUMBER, RATE, Row,
                                                           Tags)
from img_recog.simulation.sensors.rays import RaySensor
from img_recog.simulation.sensors.sensor import Mount
from img_recog.simulation.settings import SimulationError

# of libgazebo_ros_laser and _gpu_laser of gazebo_plugins, and of Gazebo's own ray sensors
TAGS = Tags(('gazebo_ros_laser', 'gazebo_ros_gpu_laser'), (
    Row('scan_period_s', RATE, 'sensor', 'update_rate'),
    Row('scan_samples', INTEGER, 'sensor', 'ray/scan/horizontal/samples'),
    Row('scan_angle_min', NUMBER, 'sensor', 'ray/scan/horizontal/min_angle'),
    Row('scan_angle_max', NUMBER, 'sensor', 'ray/scan/horizontal/max_angle'),
    Row('scan_range_min', NUMBER, 'sensor', 'ray/range/min'),
    Row('scan_range_max', NUMBER, 'sensor', 'ray/range/max'),
    Row('scan_noise', NUMBER, 'sensor', 'ray/noise/stddev'),
    Row('scan_frame', NAME, 'plugin', 'frameName'),
    Row('scan_topic', NAME, 'plugin', 'topicName')),
    sensors=('ray', 'gpu_ray'), frame='scan_frame', needs_sensor=True)


@dataclass(frozen=True)
class ScanSettings(Settings):
    """The laser scanner.

    Angles in rad about z of `scan_frame`, from its x axis; there is a ray at both ends. Ranges
    and the standard deviation of their noise in m. scan_period_s: a multiple of the physics step,
    in simulated s.
    """

    scan_frame: str = setting('base_scan', not_empty())
    scan_period_s: float = setting(0.2, above(0))
    scan_samples: int = setting(360, between(2, 16383))
    scan_angle_min: float = setting(0.0, any_value())
    scan_angle_max: float = setting(6.28319, any_value())
    scan_range_min: float = setting(0.120, at_least(0))
    scan_range_max: float = setting(3.5, above(0))
    scan_noise: float = setting(0.01, at_least(0))
    scan_topic: str = setting('scan', not_empty())

    def angles(self) -> np.ndarray:
        """Return the angle of each ray in rad.

        >>> ScanSettings(scan_samples=3, scan_angle_max=1.0).angles().tolist()
        [0.0, 0.5, 1.0]
        """
        return np.linspace(self.scan_angle_min, self.scan_angle_max, self.scan_samples)


class LaserScanner(RaySensor):
    """Measures ranges, float64 of shape (scan_samples,), in m, +inf where nothing is hit.

    rays.py finds the distances; here, noise and limits are added.
    """

    def __init__(self, mount: Mount, settings: ScanSettings):
        """Mount the scanner on a link of the robot.

        Raises SimulationError when the robot has no such link, or the shortest range is not less
        than the longest.
        """
        if not settings.scan_range_min < settings.scan_range_max:
            raise SimulationError('scan_range_min: got {:g} m, expected less than scan_range_max, '
                                  '{:g} m'.format(settings.scan_range_min,
                                                  settings.scan_range_max))
        mount.robot.check_frame('scan_frame', settings.scan_frame)
        angles = settings.angles()
        super().__init__(mount, settings.scan_frame,
                         np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)]),
                         settings.scan_range_max)
        self._settings, self._noise = settings, mount.noise

    def measure(self, distances: np.ndarray) -> np.ndarray:
        """Return the ranges; noise is added to hits, which stay within the allowed ranges."""
        settings = self._settings
        missed = distances > settings.scan_range_max
        # drawn for every ray, so that the noise does not depend on what is hit
        measured = distances + self._noise.normal(0.0, settings.scan_noise, len(distances))
        measured = np.clip(measured, settings.scan_range_min, settings.scan_range_max)
        return np.where(missed, np.inf, measured)
