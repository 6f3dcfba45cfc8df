"""An inertial measurement unit."""
from dataclasses import dataclass
from typing import Iterator, List, NamedTuple, Optional

import numpy as np

from img_recog.formats import noises
from img_recog.formats.gazebo_tags import (DEVIATION, EACH_STEP, NAME, POSITIVE, RATE, TOPIC,
                                           Row, Tags)
from img_recog.formats.noises import Noise
from img_recog.formats.reader import Type
from img_recog.rotations import Quaternion, into_frame
from img_recog.settings import Settings, above, any_value, at_least, not_empty, setting
from img_recog.simulation.physics.body import Vector, velocity_at
from img_recog.simulation.sensors.sensor import Mount, Sensor

_NOISE_ROWS = 1000          # drawn at a time
_AXES = 6                   # of angular velocity and acceleration

# of libgazebo_ros_imu and _imu_sensor of gazebo_plugins, of libhector_gazebo_ros_imu, and of
# Gazebo's own imu sensors, whose <noise> only _imu_sensor gets
TAGS = Tags(('gazebo_ros_imu',), (
    # added to angular velocities and accelerations alike
    Row('gyro_noise', POSITIVE, 'plugin', 'gaussianNoise'),
    Row('accel_noise', POSITIVE, 'plugin', 'gaussianNoise'),
    Row('imu_period_s', RATE, 'sensor', 'update_rate'),
    Row('imu_noises', Type('', noises.of_imu, of_element=True), 'sensor', 'imu'),
    Row('imu_frame', NAME, 'plugin', 'frameName', 'bodyName'),
    Row('imu_frame', NAME, 'plugin', 'frameId'),
    Row('gyro_noise', DEVIATION, 'plugin', 'rateGaussianNoise'),
    Row('accel_noise', DEVIATION, 'plugin', 'accelGaussianNoise'),
    Row('imu_topic', TOPIC, 'plugin', 'topicName'),
    Row('imu_period_s', RATE, 'plugin', 'updateRate', 'updateRateHZ')),
    sensors=('imu',), frame='imu_frame', bare={'imu_period_s': EACH_STEP},
    defaults={'gazebo_ros_imu': {'imu_period_s': EACH_STEP, 'imu_gravity': False,
                                 'imu_topic': 'default_imu'},
              'gazebo_ros_imu_sensor': {'imu_period_s': 1.0, 'imu_gravity': True,
                                        'imu_topic': 'imu'},
              'hector': {'imu_gravity': True, 'imu_topic': 'imu'}})


@dataclass(frozen=True)
class ImuSettings(Settings):
    """The IMU; standard deviations of its noise in rad/s and m/s2.

    imu_frame: without a <gazebo> tag, the link that carries it, '' for none. imu_period_s: a
    multiple of the physics step, in simulated s. imu_gravity: whether the linear acceleration is
    the specific force. The noise is in addition to that of SDF's <noise>.
    """

    imu_frame: str = setting('', any_value())
    imu_period_s: float = setting(0.001, above(0))
    gyro_noise: float = setting(0.0, at_least(0))
    accel_noise: float = setting(0.0, at_least(0))
    imu_gravity: bool = setting(True)
    imu_topic: str = setting('imu', not_empty())


class ImuReading(NamedTuple):
    """What the unit measures, in its own frame except for the orientation.

    orientation: unit quaternion (x, y, z, w), in the world, without noise; angular_velocity:
    rad/s; linear_acceleration: specific force in m/s2, 9.8 upwards at rest (REP 145), or without
    gravity, 0 at rest.
    """

    orientation: Quaternion
    angular_velocity: Vector
    linear_acceleration: Vector


class Imu(Sensor):
    """Derives the acceleration from the velocities of its frame at two successive readings."""

    def __init__(self, mount: Mount, settings: ImuSettings):
        """Mount the unit on a link of the robot; SimulationError when there is no such link."""
        self._robot, self._frame = mount.robot, mount.frame('imu_frame', settings.imu_frame)
        self._period_s = settings.imu_period_s
        given = mount.file_noises or (Noise(),) * _AXES
        self._distribution = (
            mount.noise, np.array([each.offset(mount.noise) for each in given]),
            np.hypot(np.repeat((settings.gyro_noise, settings.accel_noise), 3),
                     [each.deviation for each in given]))
        self.forget_noise()
        self._rounded = [(number, each) for number, each in enumerate(given) if each.precision]
        self._world, self._share = mount.world, float(settings.imu_gravity)
        self.restart()

    def restart(self) -> None:
        """Forget the last velocity, as after a teleport or a time in which nothing was read."""
        self._velocity: Optional[Vector] = None

    def notify_teleported(self) -> None:
        """Measure no acceleration where the robot was moved from outside."""
        self.restart()

    def skip_noise(self, readings: int) -> None:
        """Pass over the noise of readings that are not made."""
        for _ in range(readings):
            next(self._noise)

    def forget_noise(self) -> None:
        """Draw the next noise anew."""
        self._noise = _rows(*self._distribution)

    def read(self) -> ImuReading:
        """Return what the unit measures now; to be called once a period."""
        # written out: this is called 200 times a second, and loops take several times as long
        state = self._robot.frame_state(self._frame)
        position, orientation = state.frame
        velocity = velocity_at(position, *state[1:])
        before = self._velocity or velocity
        self._velocity = velocity
        period_s = self._period_s
        # the force at rest is against gravity, REP 145
        share, gravity = self._share, self._world.file.gravity
        (vx, vy, vz), (lx, ly, lz), (gx, gy, gz) = velocity, before, gravity
        force = ((vx - lx) / period_s - share * gx, (vy - ly) / period_s - share * gy,
                 (vz - lz) / period_s - share * gz)
        (ax, ay, az), (fx, fy, fz) = into_frame(orientation, state.angular, force)
        e0, e1, e2, e3, e4, e5 = next(self._noise)
        values = [ax + e0, ay + e1, az + e2, fx + e3, fy + e4, fz + e5]
        for number, noise in self._rounded:
            values[number] = float(noise.rounded(values[number]))
        ax, ay, az, fx, fy, fz = values
        return ImuReading(orientation, (ax, ay, az), (fx, fy, fz))


def _rows(noise: np.random.RandomState, means: np.ndarray,
          deviations: np.ndarray) -> Iterator[List[float]]:
    """Yield rows of normally distributed noise with these means and standard deviations."""
    while True:
        yield from (means + noise.standard_normal((_NOISE_ROWS, _AXES)) * deviations).tolist()
