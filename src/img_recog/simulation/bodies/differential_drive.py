"""The wheel speeds of a differential drive, ramped like libgazebo_ros_diff_drive does."""
from typing import Callable, Tuple

from img_recog.simulation.settings import DriveSettings

# m/s at the rim: once one wheel is this near to its target, the ramp of both ends (gazebo_plugins)
_RAMP_END_TOLERANCE = 0.01
_ROUNDING_PERIODS = 1e-6        # 0.07 s divided by 0.01 s is a little more than 7


class DifferentialDrive:
    """Turns a Twist into wheel speeds that change no faster than `wheel_acceleration`.

    timed_out: whether `cmd_vel_timeout` has ended the last command, which was not a stop.
    """

    def __init__(self, settings: DriveSettings):
        self._half_separation = settings.wheel_separation / 2
        self._radius = settings.wheel_diameter / 2
        self._max_change = settings.wheel_acceleration * settings.drive_period_s
        self._limits = settings.max_linear_velocity, settings.max_angular_velocity
        self._period_s = settings.drive_period_s
        # in periods: counting is exact, adding up seconds is not
        self._timeout = self._given_timeout = settings.cmd_vel_timeout / settings.drive_period_s
        self.reset()

    @property
    def timeout_s(self) -> float:
        """After which time without a command it stops; 0 for never."""
        return self._timeout * self._period_s

    def scale_timeout(self, factor: float) -> None:
        """Make `cmd_vel_timeout` this many times as long as it is in the settings."""
        self._timeout = factor * self._given_timeout

    def reset(self) -> None:
        """Forget the last command and stand."""
        self._target: Tuple[float, float] = (0.0, 0.0)
        self._sent: Tuple[float, float] = (0.0, 0.0)
        self._age = 0
        self.timed_out = False

    def command(self, linear_x: float, angular_z: float) -> None:
        """Set the velocity of the root link that holds until the next command: m/s and rad/s."""
        linear_x, angular_z = (
            max(-limit, min(limit, value)) if limit else value
            for value, limit in zip((linear_x, angular_z), self._limits))
        difference = angular_z * self._half_separation
        self._target = (linear_x - difference, linear_x + difference)
        self._age = 0
        self.timed_out = False

    def update(self, measure: Callable[[], Tuple[float, float]]) -> Tuple[float, float]:
        """Return the target angular velocities of the left and right wheel, in rad/s.

        measure: returns the present ones, in rad/s; it is called if they matter. To be called
        once a drive period.
        """
        if self._timeout and self._age > self._timeout - _ROUNDING_PERIODS:
            self.timed_out = self.timed_out or self._target != (0.0, 0.0)
            self._target = (0.0, 0.0)
        self._age += 1
        if self._sent != self._target:
            if self._max_change == 0 or self._is_near(measure()):
                self._sent = self._target
            else:
                self._sent = (self._ramped(self._sent[0], self._target[0]),
                              self._ramped(self._sent[1], self._target[1]))
        left, right = self._sent
        return left / self._radius, right / self._radius

    def _is_near(self, velocities: Tuple[float, float]) -> bool:
        return any(abs(target - velocity * self._radius) < _RAMP_END_TOLERANCE
                   for target, velocity in zip(self._target, velocities))

    def _ramped(self, sent: float, target: float) -> float:
        return sent + max(-self._max_change, min(self._max_change, target - sent))
