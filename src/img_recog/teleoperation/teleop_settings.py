"""Settings of what drives by hand; the defaults are those of turtlebot3_teleop."""
from dataclasses import dataclass

from img_recog.settings import Settings, above, setting


PERIOD_S = 0.1      # between two commands


@dataclass(frozen=True)
class VelocityLimits(Settings):
    """Limits of the velocities in m/s and rad/s: those of the burger (TurtleBot3 e-manual)."""

    max_linear_velocity: float = setting(0.22, above(0))
    max_angular_velocity: float = setting(2.84, above(0))


@dataclass(frozen=True)
class TeleopSettings(VelocityLimits):
    """Limits, and steps of the keys.

    linear_step, angular_step: how much one key changes the target velocity, in m/s and rad/s; each
    tick changes the sent velocity by at most half of it.

    >>> TeleopSettings(linear_step=0)
    Traceback (most recent call last):
    ...
    img_recog.settings.SettingError: linear_step: got 0.0, allowed is a finite number above 0
    """

    linear_step: float = setting(0.01, above(0))
    angular_step: float = setting(0.1, above(0))
