"""The wheel speeds of a differential drive, as libgazebo_ros_diff_drive ramps them."""
from typing import Tuple

from img_recog.simulation.settings import DriveSettings

# m/s at the rim; a wheel this near to its target ends the ramp of both (gazebo_plugins)
_CLOSE = 0.01
_ROUNDING = 1e-6        # periods: 0.07 s by 0.01 s is a little more than 7


class DifferentialDrive:
    """Turns a Twist into wheel speeds that change no faster than the wheels may accelerate."""

    def __init__(self, settings: DriveSettings):
        self._half_separation = settings.wheel_separation / 2
        self._radius = settings.wheel_diameter / 2
        self._step = settings.wheel_acceleration * settings.drive_period_s
        self._limits = settings.max_linear_velocity, settings.max_angular_velocity
        # in periods, since simulated time is counted, not summed up
        self._timeout = settings.cmd_vel_timeout / settings.drive_period_s
        self.reset()

    def reset(self) -> None:
        """Forget the last command and stand."""
        self._target = self._sent = (0.0, 0.0)
        self._age = 0

    def command(self, linear_x: float, angular_z: float) -> None:
        """Take the command that holds until the next one: m/s and rad/s of the root link."""
        linear_x, angular_z = (
            max(-limit, min(limit, value)) if limit else value
            for value, limit in zip((linear_x, angular_z), self._limits))
        difference = angular_z * self._half_separation
        self._target = (linear_x - difference, linear_x + difference)
        self._age = 0

    def update(self, velocities: Tuple[float, float]) -> Tuple[float, float]:
        """Return the angular velocities to ask of the left and right wheel, in rad/s.

        velocities: those measured now, in rad/s. To be called once a drive period.
        """
        if self._timeout and self._age > self._timeout - _ROUNDING:
            self._target = (0.0, 0.0)
        self._age += 1
        near = any(abs(target - velocity * self._radius) < _CLOSE
                   for target, velocity in zip(self._target, velocities))
        if self._step == 0 or near:
            self._sent = self._target
        else:
            self._sent = tuple(sent + max(-self._step, min(self._step, target - sent))
                               for sent, target in zip(self._sent, self._target))
        left, right = self._sent
        return left / self._radius, right / self._radius
