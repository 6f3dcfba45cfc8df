"""What all sensors of a robot have in common."""
import abc
from typing import Any, Callable, NamedTuple

import numpy as np

from img_recog.simulation.bodies.drive import Drive
from img_recog.simulation.bodies.robot import SimulatedRobot
from img_recog.simulation.bodies.world import World
from img_recog.simulation.descriptions.gazebo_tags import Tags


class Sensor(abc.ABC):
    """Measures something of a robot once in a period."""

    @abc.abstractmethod
    def read(self) -> Any:
        """Return what is measured now."""

    def restart(self) -> None:
        """Forget earlier measurements; does nothing where a value does not depend on them."""

    def notify_teleported(self) -> None:
        """Call after the robot was moved from outside."""


class Mount(NamedTuple):
    """What a sensor is made for.

    robot: its links carry the sensor; noise: the random generator of this sensor alone; drive:
    of the robot.
    """

    robot: SimulatedRobot
    world: World
    noise: np.random.RandomState
    drive: Drive


class SensorKind(NamedTuple):
    """A row of the table of sensors, conversions/sensor_table.py.

    name: of the sensor, with which the names of its settings begin. settings: their class, with
    the field NAME_period_s; with NAME_topic, if the topic is not always NAME; with NAME_frame, if
    a robot without the link of the default goes without the sensor. Other fields that end in
    _topic or _frame are names of topics and frames too; an empty frame is the root link.
    make: make(mount, settings) returns a Sensor. tags: where <gazebo> tags have its settings.
    msg_type: what is published. to_msg: to_msg(reading, settings, stamp, out) returns the message.
    noise_number: of its random generator, a number that no other row has.
    """

    name: str
    settings: type
    make: Callable[[Mount, Any], Sensor]
    tags: Tags
    msg_type: type
    to_msg: Callable[..., Any]
    noise_number: int

    def topic(self, settings: Any) -> str:
        """Return the name of the topic."""
        return getattr(settings, self.name + '_topic', self.name)

    def frame(self, settings: Any) -> str:
        """Return the link that the robot may not have, '' if there is none."""
        return getattr(settings, self.name + '_frame', '')


class ScheduledSensor:
    """A sensor with its name and period; it is read only while it is enabled."""

    def __init__(self, name: str, period_steps: int, sensor: Sensor):
        self.name, self.period_steps, self.sensor = name, period_steps, sensor
        self.enabled = True
