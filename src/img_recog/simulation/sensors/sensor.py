"""What all sensors of a robot have in common."""
import abc
from typing import Any, Callable, List, NamedTuple, Optional, Sequence

import numpy as np

from img_recog.formats.gazebo_tags import Tags, Values
from img_recog.formats.noises import Noise
from img_recog.model import AttachedFrame
from img_recog.settings import nearest_period
from img_recog.simulation.physics.drive import Drive
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.world import World
from img_recog.simulation.simulation_settings import topic_fields, whole_steps


class Sensor(abc.ABC):
    """Measures something of a robot once in a period."""

    @abc.abstractmethod
    def read(self) -> Any:
        """Return what is measured now."""

    def restart(self) -> None:
        """Forget earlier measurements; does nothing where a value does not depend on them."""

    def notify_teleported(self) -> None:
        """Call after the robot was moved from outside."""

    def skip_noise(self, readings: int) -> None:
        """Pass over the noise of readings that are not made; does nothing where there is none."""

    def forget_noise(self) -> None:
        """Forget noise that was drawn ahead; does nothing where none is."""


class Mount(NamedTuple):
    """What a sensor is made for.

    robot: its links carry the sensor; noise: the random generator of this sensor alone; drive:
    of the robot, None for a model without one. place: a frame of the robot, where the tag of the
    sensor puts it, and link: the one of the robot that it names; '' if it has none: then the
    sensor is on the link that its settings name. file_noises: those that SDF's <noise> gives.
    """

    robot: FramedBody
    world: World
    noise: np.random.RandomState
    drive: Optional[Drive]
    place: str = ''
    link: str = ''
    file_noises: Sequence[Noise] = ()

    def frame(self, setting: str, link: str) -> str:
        """Return the frame of the robot in which a sensor measures.

        setting, link: that names the link. SimulationError if it counts and is not a link.
        """
        if not self.place:
            self.robot.check_frame(setting, link)
        return self.place or link


class SensorKind(NamedTuple):
    """A row of the table of sensors, conversions/sensor_table.py.

    name: of the sensor, with which the names of its settings begin. settings: their class, with
    the field NAME_period_s, or NAME_rate in Hz; with NAME_topic, if the topic is not always NAME,
    or several others; with NAME_frame, the link that carries it: a robot with no tag of it has it
    if that is not empty, and has such a link. Other fields that end in
    _topic or _frame are names of topics and frames too; an empty frame is the root link.
    make: make(mount, settings) returns a Sensor. tags: where <gazebo> tags have its settings.
    msg_type: what is published. to_msg: to_msg(reading, settings, stamp, out) returns the message;
    None for what is drawn elsewhere, and is disabled until then.
    noise_number: of its random generator, a number that no other row has. only_in_tags: whether
    a robot has such sensors only where its <gazebo> tags have them; the settings are no
    parameters then. missing: why its messages cannot be made, '' if they can: such a sensor in
    <gazebo> tags is not simulated.
    """

    name: str
    settings: type
    make: Callable[[Mount, Any], Sensor]
    tags: Tags
    msg_type: type
    to_msg: Any
    noise_number: int
    only_in_tags: bool = False
    missing: str = ''

    @property
    def is_drawn(self) -> bool:
        """Whether its readings are drawn before they are published."""
        return self.to_msg is None

    @property
    def read_tags(self) -> Tags:
        """The tags as they are read: those of a missing sensor are only reported."""
        if not self.missing:
            return self.tags
        return self.tags._replace(
            not_simulated=lambda _: ['sensor {} ({})'.format(self.name, self.missing)])

    def topics(self, settings: Any) -> List[str]:
        """Return the names of the topics, one if it is not drawn."""
        return [getattr(settings, field) for field in topic_fields(settings)] or [self.name]

    def topic(self, settings: Any) -> str:
        """Return the name of the first topic."""
        return self.topics(settings)[0]

    def period_steps(self, settings: Any, step_s: float) -> int:
        """Return the steps of the physics in its period; errors as for `whole_steps`."""
        name, rate = self.name + '_period_s', getattr(settings, self.name + '_rate', None)
        return whole_steps(name, nearest_period(rate, step_s) if rate else getattr(settings, name),
                           step_s)

    def frame(self, settings: Any) -> str:
        """Return the link that the robot may not have, '' if there is none."""
        return getattr(settings, self.name + '_frame', '')


class ConfiguredSensor(NamedTuple):
    """A sensor of a robot.

    number: among those of its kind, from 0. values: the settings in its tag, by name, none for one
    without a tag. place: where its tag puts it, None if nothing says it; label: its own name;
    type: of its <sensor>, '' if it is a plugin alone; is_bare: whether it has no plugin that
    publishes what it measures.
    """

    kind: SensorKind
    number: int = 0
    values: Values = {}
    place: Optional[AttachedFrame] = None
    label: str = ''
    type: str = ''
    is_bare: bool = False

    @property
    def name(self) -> str:
        """The name of its readings: for the first of a kind, that of the kind."""
        return '{}_{}'.format(self.kind.name, self.number + 1) if self.number else self.kind.name

    @property
    def reads_parameters(self) -> bool:
        """Whether parameters of the user count more than its tag."""
        return self.number == 0 and not self.kind.only_in_tags
