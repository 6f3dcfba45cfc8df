"""Sensors that cast rays into the world; those of all robots are read together."""
import abc
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.formats.gazebo_tags import INTEGER, NUMBER, RATE, Row
from img_recog.formats.reader import name_of, text_of
from img_recog.simulation.physics.solids import Bundles
from img_recog.simulation.sensors.sensor import Mount, Sensor

_MAX_OWN_SHAPES = 20        # of its own robot, that a ray may cross one after the other
_BATCH = 8192               # PyBullet has a limit, and loses the last ray at it
_MAX_RAYS = 200000
_PAST_M = 1e-3              # a ray goes on so far behind the surface of such a shape


def fan_rows(prefix: str, limits: str) -> Tuple[Row, ...]:
    """Return where the rate, the directions and the limits of rays are; arguments as for
    FanSensor.
    """
    scan = 'ray/scan/'
    return tuple(Row(setting, reader, 'sensor', path) for setting, reader, path in (
        (prefix + '_period_s', RATE, 'update_rate'),
        (prefix + '_samples', INTEGER, scan + 'horizontal/samples'),
        (prefix + '_angle_min', NUMBER, scan + 'horizontal/min_angle'),
        (prefix + '_angle_max', NUMBER, scan + 'horizontal/max_angle'),
        (prefix + '_rows', INTEGER, scan + 'vertical/samples'),
        (prefix + '_pitch_min', NUMBER, scan + 'vertical/min_angle'),
        (prefix + '_pitch_max', NUMBER, scan + 'vertical/max_angle'),
        (limits + '_min', NUMBER, 'ray/range/min'),
        (limits + '_max', NUMBER, 'ray/range/max')))


def sees_nothing(sensor: ElementTree.Element) -> Sequence[str]:
    """Return what is said of a sensor without the distance to which it sees."""
    return [] if text_of(sensor, 'ray/range/max') else [
        'what sensor {} could see, because it has no <max> of its <range>, which is 0 then'
        .format(name_of(sensor))]


class RaySensor(Sensor):
    """Casts all rays at one time from the origin of its frame.

    As in Gazebo, rays begin at the shortest range and see their own robot; not those of its shapes
    that are the convex hull of a mesh.
    """

    def __init__(self, mount: Mount, frame: str, directions: np.ndarray,
                 limits: Tuple[float, float]):
        """Mount the sensor where its tag puts it, else on the link `frame`.

        directions (3, rays): unit vectors in that frame; limits: from and to which distance
        something is seen, in m. SimulationError when there are too many rays.
        """
        self.solids = mount.world.solids
        self._robot, self._frame = mount.robot, mount.place or frame
        self._directions, (self._shortest, self._longest) = directions, limits
        if self.rays > _MAX_RAYS:
            raise SimulationError('got {} rays, at most {} are simulated'.format(
                self.rays, _MAX_RAYS), 'give the sensor fewer samples')

    @abc.abstractmethod
    def measure(self, distances: np.ndarray) -> Any:
        """Return what the sensor measures where its rays go so far, (rays,), in m; inf or farther
        than the longest is nothing.
        """

    def read(self) -> Any:
        """Return what is measured now."""
        return read_together([self])[0]

    @property
    def rays(self) -> int:
        """The number of rays."""
        return self._directions.shape[1]

    def bundle(self) -> Bundles:
        """Return the rays from where the sensor is now, a bundle."""
        motion = self._robot.motion(self._frame)
        directions = (rotations.matrix(motion.orientation) @ self._directions).T
        return Bundles(motion.position[None], directions[None], np.array([self._shortest]),
                       np.array([self._longest]))

    def cast(self, bundle: Bundles) -> np.ndarray:
        """Return what Solids.distances does, by PyBullet's rays, for shapes of all kinds but those
        of the robot, and those in which a ray begins.
        """
        longest = self._longest
        directions = bundle.directions[0]
        ends = bundle.starts[0] + longest * directions
        passed = np.full(len(directions), self._shortest)      # how far each ray has come
        distances = np.full(len(directions), np.inf)
        rays = np.arange(len(directions))
        for _ in range(_MAX_OWN_SHAPES):
            starts = bundle.starts[0] + passed[rays, None] * directions[rays]
            hits = [hit for first in range(0, len(rays), _BATCH) for hit in pybullet.rayTestBatch(
                starts[first:first + _BATCH].tolist(),
                ends[rays[first:first + _BATCH]].tolist(), numThreads=0,
                **self._robot.client)]
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


class FanSensor(RaySensor):
    """Casts rows of rays; those of a row are about z of its frame, and the rows one above another.

    The settings have the names of `fan_rows`, and PREFIX_frame.
    """

    def __init__(self, mount: Mount, settings: Any, prefix: str, limits: str):
        """Mount the sensor.

        Args:
            mount: Mount.
            settings: Settings of the sensor.
            prefix: Beginning of the names of its settings: 'scan'.
            limits: Beginning of the names of its shortest and longest range.

        Raises:
            SimulationError: if the robot has no link for it, or the shortest range is not less
                than the longest, unless that is 0, with which it sees nothing.
        """
        def value(name: str) -> Any:
            return getattr(settings, prefix + name)
        shortest, longest = (getattr(settings, limits + end) for end in ('_min', '_max'))
        if longest and not shortest < longest:
            raise SimulationError('{0}_min: got {1:g} m, expected less than {0}_max, {2:g} m'
                                  .format(limits, shortest, longest))
        super().__init__(
            mount, mount.frame(prefix + '_frame', value('_frame')),
            directions(angles(value('_samples'), value('_angle_min'), value('_angle_max')),
                       angles(value('_rows'), value('_pitch_min'), value('_pitch_max'))),
            (shortest, longest))
        self._settings, self._noise, self._drawn = settings, mount.noise, 1

    def skip_noise(self, readings: int) -> None:
        """Pass over the noise of readings that are not made."""
        for _ in range(readings):
            self._noise.standard_normal(self._drawn)


def angles(samples: int, first: float, last: float) -> np.ndarray:
    """Return the angles of rays; a single one is at 0 (gazebo::physics::MultiRayShape::Init).

    >>> angles(3, 0.0, 1.0).tolist(), angles(1, -1.0, 0.5).tolist()
    ([0.0, 0.5, 1.0], [0.0])
    """
    return np.zeros(1) if samples == 1 else np.linspace(first, last, samples)


def directions(yaw: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """Return unit vectors (3, rays), one row of rays after the other.

    yaw: angles in rad about z, from x on; pitch: of the rows, upward from the plane of x and y.
    """
    up, across = (each.ravel() for each in np.meshgrid(pitch, yaw, indexing='ij'))
    return np.stack([np.cos(across) * np.cos(up), np.sin(across) * np.cos(up), np.sin(up)])


def read_together(sensors: Sequence[RaySensor]) -> List[Any]:
    """Return what each of some sensors of a physics client measures now."""
    bundles = [sensor.bundle() for sensor in sensors]
    distances: Dict[int, np.ndarray] = {}
    has_others = False
    for rays in {sensor.rays for sensor in sensors}:
        numbers = [number for number, sensor in enumerate(sensors) if sensor.rays == rays]
        found, has_others = sensors[0].solids.distances(Bundles(
            *map(np.concatenate, zip(*(bundles[number] for number in numbers)))))
        distances.update(zip(numbers, found))
    if has_others:
        for number, sensor in enumerate(sensors):
            distances[number] = np.minimum(distances[number], sensor.cast(bundles[number]))
    return [sensor.measure(distances[number]) for number, sensor in enumerate(sensors)]
