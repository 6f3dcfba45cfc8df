"""A laser scanner; where its tags say nothing, it has the defaults of SDF."""
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import Iterator, Optional, Tuple

import numpy as np

from img_recog.formats import noises
from img_recog.formats.gazebo_tags import EACH_STEP, NAME, NUMBER, TOPIC, Row, Tags
from img_recog.formats.noises import Noise
from img_recog.formats.reader import Type, name_of, text_of
from img_recog.settings import Settings, above, any_value, at_least, between, not_empty, setting
from img_recog.simulation.sensors import ray_sensor
from img_recog.simulation.sensors.ray_sensor import FanSensor
from img_recog.simulation.sensors.sensor import Mount


def _not_simulated(sensor: ElementTree.Element) -> Iterator[str]:
    if text_of(sensor, 'ray/scan/vertical/samples') not in ('', '1'):
        yield 'rows of rays of sensor {} above and below the middle one'.format(name_of(sensor))
    yield from ray_sensor.sees_nothing(sensor)


def _rest(element: ElementTree.Element, name: str) -> Optional[Tuple[Noise]]:
    noise = noises.read(element, name)._replace(deviation=0.0)
    return None if noise == Noise() else (noise,)


# of libgazebo_ros_laser and _gpu_laser of gazebo_plugins, and of Gazebo's own ray sensors
TAGS = Tags(('gazebo_ros_laser', 'gazebo_ros_gpu_laser'), (
    *ray_sensor.fan_rows('scan', 'scan_range'),
    Row('scan_resolution', NUMBER, 'sensor', 'ray/scan/horizontal/resolution'),
    Row('scan_noise', Type('', lambda *given: noises.read(*given).deviation, of_element=True),
        'sensor', 'ray/noise'),
    Row('scan_noises', Type('', _rest, of_element=True), 'sensor', 'ray/noise'),
    Row('scan_frame', NAME, 'plugin', 'frameName'),
    Row('scan_topic', TOPIC, 'plugin', 'topicName')),
    sensors=('ray', 'gpu_ray'), frame='scan_frame', needs_sensor=True,
    defaults={'laser': {'scan_period_s': EACH_STEP}}, bare={'scan_period_s': EACH_STEP},
    not_simulated=_not_simulated)


@dataclass(frozen=True)
class ScanSettings(Settings):
    """The laser scanner.

    scan_frame: without a <gazebo> tag, the link that carries a scanner, '' for none. Angles in rad
    about z of that, or of the place that a <gazebo> tag gives, from its x axis; there is a ray at
    both ends. scan_resolution: ranges for each ray, interpolated between
    them. scan_rows: of rays, from the angle scan_pitch_min upward to scan_pitch_max; the middle
    one is published. Ranges and the standard deviation of their noise in m. scan_period_s: a
    multiple of the physics step, in simulated s.
    """

    scan_frame: str = setting('', any_value())
    scan_period_s: float = setting(0.001, above(0))
    scan_samples: int = setting(640, between(1, 100000))
    scan_resolution: float = setting(1.0, between(0.001, 100))
    scan_rows: int = setting(1, between(1, 100000))
    scan_pitch_min: float = setting(0.0, any_value())
    scan_pitch_max: float = setting(0.0, any_value())
    scan_angle_min: float = setting(0.0, any_value())
    scan_angle_max: float = setting(0.0, any_value())
    scan_range_min: float = setting(0.0, at_least(0))
    scan_range_max: float = setting(0.0, at_least(0))
    scan_noise: float = setting(0.0, at_least(0))
    scan_topic: str = setting('scan', not_empty())

    def middle(self, ranges: np.ndarray) -> np.ndarray:
        """Return the ranges of the middle row among those of all rows.

        >>> ScanSettings(scan_rows=3).middle(np.arange(6)).tolist()
        [2, 3]
        """
        return ranges.reshape(self.scan_rows, -1)[self.scan_rows // 2]


class LaserScanner(FanSensor):
    """Measures ranges, float64 of shape (rows times ranges,), in m, +inf where nothing is hit.

    The lowest row is the first. In each are scan_samples times scan_resolution, cut to a whole
    number. FanSensor finds the distances; here, noise and limits are added.
    """

    def __init__(self, mount: Mount, settings: ScanSettings):
        """Mount the scanner; errors as for FanSensor."""
        super().__init__(mount, settings, 'scan', 'scan_range')
        self._at = _positions(settings)
        self._drawn = settings.scan_rows * (
            settings.scan_samples if self._at is None else len(self._at))
        self._file_noise = next(iter(mount.file_noises), Noise())
        self._offset = self._file_noise.offset(mount.noise)

    def measure(self, distances: np.ndarray) -> np.ndarray:
        """Return the ranges; noise is added to hits, which stay within the allowed ranges."""
        settings = self._settings
        if self._at is not None:
            distances = np.concatenate([
                _interpolated(row, self._at, settings.scan_range_max)
                for row in distances.reshape(settings.scan_rows, -1)])
        missed = distances > settings.scan_range_max
        # drawn for every ray, so that the noise does not depend on what is hit
        measured = self._file_noise.rounded(distances + self._noise.normal(
            self._offset, settings.scan_noise, len(distances)))
        measured = np.clip(measured, settings.scan_range_min, settings.scan_range_max)
        return np.where(missed, np.inf, measured)


def _positions(settings: ScanSettings) -> Optional[np.ndarray]:
    """Return where each range is among the rays, which have the numbers from 0; None if it is one.

    As in gazebo::sensors::RaySensor::UpdateImpl.
    """
    count = max(1, int(settings.scan_samples * settings.scan_resolution))
    return None if count == settings.scan_samples else np.linspace(
        0.0, (settings.scan_samples - 1.0) * (count > 1), count)


def _interpolated(distances: np.ndarray, at: np.ndarray, longest: float) -> np.ndarray:
    """Return distances between rays; a ray that hits nothing counts as the longest, like there."""
    found = np.interp(at, np.arange(len(distances)), np.minimum(distances, longest))
    return np.where(found < longest, found, np.inf)
