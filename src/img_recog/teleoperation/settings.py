"""Steps and limits of keyboard driving, those of turtlebot3_teleop for the burger."""
from dataclasses import dataclass

from img_recog.settings import Settings, above, setting


@dataclass(frozen=True)
class TeleopSettings(Settings):
    """m/s and rad/s: a key press moves the target by a step, a tick moves the sent value by half.

    max_linear_velocity, max_angular_velocity: of the real burger (TurtleBot3 e-manual).
    """

    linear_step: float = setting(0.01, above(0))
    angular_step: float = setting(0.1, above(0))
    max_linear_velocity: float = setting(0.22, above(0))
    max_angular_velocity: float = setting(2.84, above(0))
