"""Settings of the keyboard teleoperation; the defaults are those of turtlebot3_teleop."""
from dataclasses import dataclass

from img_recog.settings import Settings, above, setting


@dataclass(frozen=True)
class TeleopSettings(Settings):
    """Steps and limits of the velocities, in m/s and rad/s.

    linear_step, angular_step: how much one key changes the target velocity; each tick changes the
    sent velocity by at most half of it.
    max_linear_velocity, max_angular_velocity: of the real burger (TurtleBot3 e-manual).
    """

    linear_step: float = setting(0.01, above(0))
    angular_step: float = setting(0.1, above(0))
    max_linear_velocity: float = setting(0.22, above(0))
    max_angular_velocity: float = setting(2.84, above(0))
