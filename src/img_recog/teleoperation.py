"""Converts keys to target velocities, and target velocities to smooth commands."""
from dataclasses import dataclass
from typing import Tuple

from img_recog.settings import Settings, above, setting

PERIOD_S = 0.1      # between two commands
FORWARD, BACKWARD, LEFT, RIGHT = 'w', 'x', 'a', 'd'
STOP = ('s', ' ')


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


class VelocityProfile:
    """The target velocity, which keys change, and the sent velocity, which approaches it.

    target_linear in m/s, target_angular in rad/s.

    >>> profile = VelocityProfile()
    >>> [profile.press(key) for key in 'wwa?']
    [True, True, True, False]
    >>> profile.target_linear, profile.target_angular
    (0.02, 0.1)
    >>> [profile.tick() for _ in range(5)]
    [(0.005, 0.05), (0.01, 0.1), (0.015, 0.1), (0.02, 0.1), (0.02, 0.1)]
    """

    def __init__(self, settings: TeleopSettings = TeleopSettings()):
        self._settings = settings
        self.target_linear = self.target_angular = 0.0
        self._sent_linear = self._sent_angular = 0.0

    def press(self, key: str) -> bool:
        """Handle one key; return whether it is one of the keys below.

        w, x: faster forward, backward; a, d: faster to the left, right; s, space: stop at once.
        """
        settings = self._settings
        if key in (FORWARD, BACKWARD):
            step = settings.linear_step if key == FORWARD else -settings.linear_step
            self.target_linear = _stepped(self.target_linear, step, settings.max_linear_velocity)
        elif key in (LEFT, RIGHT):
            step = settings.angular_step if key == LEFT else -settings.angular_step
            self.target_angular = _stepped(self.target_angular, step,
                                           settings.max_angular_velocity)
        elif key in STOP:
            self.target_linear = self.target_angular = 0.0
            self._sent_linear = self._sent_angular = 0.0
        else:
            return False
        return True

    def tick(self) -> Tuple[float, float]:
        """Advance by one tick; return the command to send: linear.x in m/s, angular.z in rad/s."""
        self._sent_linear = _towards(self._sent_linear, self.target_linear,
                                     self._settings.linear_step / 2)
        self._sent_angular = _towards(self._sent_angular, self.target_angular,
                                      self._settings.angular_step / 2)
        return self._sent_linear, self._sent_angular


def _stepped(value: float, step: float, limit: float) -> float:
    # rounded, so that ten steps of 0.01 give exactly 0.1
    return max(-limit, min(limit, round(value + step, 9)))


def _towards(value: float, target: float, step: float) -> float:
    if abs(target - value) <= step:
        return target
    return round(value + step if target > value else value - step, 9)
