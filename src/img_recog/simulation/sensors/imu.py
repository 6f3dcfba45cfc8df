"""An inertial measurement unit."""
from typing import Iterator, List, NamedTuple, Optional

import numpy as np

from img_recog.rotations import Quaternion, into_frame
from img_recog.simulation.bodies.body import Vector, velocity_at
from img_recog.simulation.bodies.robot import Robot
from img_recog.simulation.sensors.sensor import Sensor
from img_recog.simulation.settings import ImuSettings

_NOISE_ROWS = 1000          # drawn at a time


class ImuReading(NamedTuple):
    """What the unit measures, in its own frame except for the orientation.

    orientation: unit quaternion (x, y, z, w), in the world, without noise; angular_velocity:
    rad/s; linear_acceleration: specific force in m/s2, 9.8 upwards at rest (REP 145).
    """

    orientation: Quaternion
    angular_velocity: Vector
    linear_acceleration: Vector


class Imu(Sensor):
    """Derives the acceleration from the velocities of its frame at two successive readings."""

    def __init__(self, robot: Robot, settings: ImuSettings, period_s: float,
                 noise: np.random.RandomState):
        """Mount the unit on a link of `robot`; SimulationError when there is no such link."""
        robot.check_frame('imu_frame', settings.imu_frame)
        self._robot, self._settings, self._period_s = robot, settings, period_s
        self._noise = _rows(noise, np.repeat((settings.gyro_noise, settings.accel_noise), 3))
        # in the world; upwards under gravity, REP 145
        self._force_at_rest = (-robot.gravity()).tolist()
        self.restart()

    def restart(self) -> None:
        """Forget the last velocity, as after a teleport or a time in which nothing was read."""
        self._velocity: Optional[Vector] = None

    def read(self) -> ImuReading:
        """Return what the unit measures now; to be called once a period."""
        # written out: this is called 200 times a second, and loops take several times as long
        state = self._robot.frame_state(self._settings.imu_frame)
        position, orientation = state.frame
        velocity = velocity_at(position, *state[1:])
        before = self._velocity or velocity
        self._velocity = velocity
        period_s = self._period_s
        (vx, vy, vz), (lx, ly, lz), (gx, gy, gz) = velocity, before, self._force_at_rest
        force = ((vx - lx) / period_s + gx, (vy - ly) / period_s + gy, (vz - lz) / period_s + gz)
        (ax, ay, az), (fx, fy, fz) = into_frame(orientation, state.angular, force)
        e0, e1, e2, e3, e4, e5 = next(self._noise)
        return ImuReading(orientation, (ax + e0, ay + e1, az + e2), (fx + e3, fy + e4, fz + e5))


def _rows(noise: np.random.RandomState, deviations: np.ndarray) -> Iterator[List[float]]:
    """Yield rows of normally distributed noise with these standard deviations."""
    while True:
        yield from (noise.standard_normal((_NOISE_ROWS, len(deviations))) * deviations).tolist()
