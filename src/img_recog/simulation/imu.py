"""An inertial measurement unit."""
from typing import NamedTuple, Optional

import numpy as np

from img_recog.simulation.body import Quaternion, rotation_matrix
from img_recog.simulation.robot import Robot
from img_recog.simulation.sensor import Sensor
from img_recog.simulation.settings import ImuSettings


class ImuReading(NamedTuple):
    """What the unit measures, in its own frame except for the orientation.

    orientation: unit quaternion (x, y, z, w), in the world, without noise; angular_velocity
    (3,): rad/s; linear_acceleration (3,): specific force in m/s2, 9.8 upwards at rest (REP 145).
    """

    orientation: Quaternion
    angular_velocity: np.ndarray
    linear_acceleration: np.ndarray


class Imu(Sensor):
    """Derives the acceleration from the velocities of its frame at two successive readings."""

    def __init__(self, robot: Robot, settings: ImuSettings, period_s: float,
                 noise: np.random.RandomState):
        """Mount the unit on a link of `robot`; SimulationError when there is no such link."""
        robot.check_frame('imu_frame', settings.imu_frame)
        self._robot, self._settings, self._noise = robot, settings, noise
        self._period_s = period_s
        # in the world; upwards under gravity, REP 145
        self._force_at_rest = -robot.gravity()
        self._deviations = np.repeat((settings.gyro_noise, settings.accel_noise), 3)
        self.restart()

    def restart(self) -> None:
        """Forget the last velocity, as after a teleport or a time in which nothing was read."""
        self._velocity: Optional[np.ndarray] = None

    def read(self) -> ImuReading:
        """Return what the unit measures now; to be called once a period."""
        motion = self._robot.motion(self._settings.imu_frame)
        to_world = rotation_matrix(motion.orientation)
        velocity = to_world @ motion.linear
        before = velocity if self._velocity is None else self._velocity
        self._velocity = velocity
        force = ((velocity - before) / self._period_s + self._force_at_rest) @ to_world
        noise = self._noise.standard_normal(6) * self._deviations
        return ImuReading(motion.orientation, motion.angular + noise[:3], force + noise[3:])
