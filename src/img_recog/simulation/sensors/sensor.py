"""The interface of the sensors of a robot."""
import abc
from typing import Any


class Sensor(abc.ABC):
    """Measures something of a robot once in a period."""

    @abc.abstractmethod
    def read(self) -> Any:
        """Return what is measured now."""

    def restart(self) -> None:
        """Forget earlier measurements; does nothing where a value does not depend on them."""


class ScheduledSensor:
    """A sensor with its name and period; it is read only while it is enabled."""

    def __init__(self, name: str, period_steps: int, sensor: Sensor):
        self.name, self.period_steps, self.sensor = name, period_steps, sensor
        self.enabled = True
