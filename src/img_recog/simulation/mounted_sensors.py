"""The sensors of a body; each is read once in a period."""
import dataclasses
import sys
from typing import Any, Collection, Dict, List, NamedTuple, Optional, Set

import numpy as np

from img_recog.simulation.physics.drive import Drive
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.world import World
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.sensors.ray_sensor import RaySensor
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.sensors.sensor import Mount, ConfiguredSensor, ScheduledSensor


class Reading(NamedTuple):
    """What a sensor measured.

    robot, sensor: their names; kind: of the sensor; time_s: simulated time; value: of the type
    that the sensor's `read` returns.
    """

    robot: str
    sensor: str
    kind: str
    time_s: float
    value: Any


class MountedSensors:
    """The sensors of one body.

    Attributes:
        spec: Configuration from which the sensors were made.
        body: Body whose links carry the sensors.
        settings: Settings of all sensors, in which an empty frame is the root link.
        missing: Links that the body does not have, by the names of the sensors that are left out.
    """

    def __init__(self, spec: ConfiguredModel, world: World, body: FramedBody,
                 drive: Optional[Drive] = None):
        """Mount the sensors.

        Raises:
            SimulationError: if a setting does not fit.
        """
        self.spec, self.body, self._world = spec, body, world
        self.settings = dataclasses.replace(spec.settings, sensors={
            each.name: _with_root(spec.settings.sensors.get(each.name) or each.kind.settings(),
                                  body.model.root) for each in spec.sensors})
        self._sensors: Dict[str, ScheduledSensor] = {}
        self.missing: Dict[str, str] = {}
        for each in spec.sensors:
            self._mount(each, self.settings.sensors[each.name], drive)
        self._enabled = [each for each in self._sensors.values() if each.enabled]
        self._steps: Optional[int] = None       # the last ones that it was told of

    def _mount(self, sensor: ConfiguredSensor, settings: Any, drive: Optional[Drive]) -> None:
        """Add a sensor, but not when only its tag or the default names a link that is missing."""
        kind, place = sensor.kind, sensor.place
        link = place.link if place else kind.frame(settings)
        of_file = kind.frame(kind.settings()), sensor.values.get(kind.name + '_frame')
        if link and not self.body.has_frame(link) and (place or link in of_file):
            self.missing[sensor.name] = link
            return
        mount = ''
        if place:
            mount = 'sensor ' + sensor.name
            self.body.add_mount(mount, *place)
        # a generator each: the noise of one sensor does not depend on whether another is read
        noise = np.random.RandomState((self.settings.noise.seed, kind.noise_number)
                                      + (sensor.number,) * bool(sensor.number))
        self._sensors[sensor.name] = ScheduledSensor(
            sensor.name, kind.name, kind.period_steps(settings, self._world.step_s),
            kind.make(Mount(self.body, self._world, noise, drive, mount, link,
                            sensor.values.get(kind.name + '_noises', ())), settings), noise)
        self._sensors[sensor.name].enabled = not kind.is_drawn

    @property
    def cameras(self) -> Dict[str, RobotCamera]:
        """The cameras by the names of their sensors."""
        return {name: scheduled.sensor for name, scheduled in self._sensors.items()
                if isinstance(scheduled.sensor, RobotCamera)}

    def set_enabled(self, sensor: str, enabled: bool) -> None:
        """Enable or disable a sensor; does nothing when the robot does not have it.

        Sensors do not influence how the robot moves. The noise of a reading is the same whether
        the sensor was enabled before or not.
        """
        scheduled = self._sensors.get(sensor)
        if scheduled is None or scheduled.enabled == enabled:
            return
        scheduled.enabled = enabled
        if enabled:
            scheduled.sensor.restart()
        if self._steps is not None:
            if enabled:
                scheduled.skip_until(self._steps)
            else:
                scheduled.skipped_from = self._steps
        self._enabled = [each for each in self._sensors.values() if each.enabled]

    def before_step(self, steps: int) -> None:
        """Count the readings that are not made from a step on: the first, or after a reset."""
        if self._steps is None:
            for scheduled in self._sensors.values():
                scheduled.skipped_from = steps
            self._steps = steps

    def due(self, steps: int) -> List[ScheduledSensor]:
        """Return the sensors that are to be read after `steps` steps."""
        self._steps = steps
        return [scheduled for scheduled in self._enabled if steps % scheduled.period_steps == 0]

    def next_event(self, steps: int) -> int:
        """Return the first step after `steps` at which a sensor is read."""
        wait = sys.maxsize
        for scheduled in self._enabled:
            remaining = scheduled.period_steps - steps % scheduled.period_steps
            if remaining < wait:
                wait = remaining
        return steps + wait

    @property
    def kinds(self) -> Set[str]:
        """The kinds of sensors that the robot has, also of those that are disabled."""
        return {each.kind for each in self._sensors.values()}

    def next_reading(self, steps: int, kinds: Collection[str]) -> Optional[int]:
        """Return the first step after `steps` at which a sensor of some kinds is read.

        None if there is no such sensor.
        """
        return min((steps + each.period_steps - steps % each.period_steps
                    for each in self._enabled if each.kind in kinds), default=None)

    def reset(self) -> None:
        """Let the sensors begin anew."""
        for scheduled in self._sensors.values():
            scheduled.sensor.restart()

    def restart_noise(self) -> None:
        """Let the noise of the sensors begin anew, as when time does."""
        for scheduled in self._sensors.values():
            scheduled.restart_noise()
        self._steps = None

    def notify_teleported(self) -> None:
        """Call after the robot was moved from outside."""
        for scheduled in self._sensors.values():
            scheduled.sensor.notify_teleported()

    def measure(self) -> Dict[str, Any]:
        """Return what the rays of sensors hit now, by the names of the sensors."""
        return {name: scheduled.sensor.read() for name, scheduled in self._sensors.items()
                if isinstance(scheduled.sensor, RaySensor)}


def _with_root(settings: Any, root: str) -> Any:
    """Return the settings of a sensor with the root link for each empty frame."""
    return dataclasses.replace(settings, **{
        field.name: root for field in dataclasses.fields(settings)
        if field.name.endswith('_frame') and not getattr(settings, field.name)})
