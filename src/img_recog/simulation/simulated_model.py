"""Models with sensors, and robots: models with a drive."""
import dataclasses
import sys
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple, cast

import numpy as np

from img_recog import rotations
from img_recog.model import Tree
from img_recog.simulation.configured_model import ConfiguredModel
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.physics.drive import Drive
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.model_bodies import ModelBodies
from img_recog.simulation.physics.robot import RobotBody
from img_recog.simulation.physics.world import World
from img_recog.simulation.sensors.odometry import WORLD, OdometrySettings
from img_recog.simulation.sensors.ray_sensor import RaySensor
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.sensors.sensor import ConfiguredSensor, Mount, Sensor
from img_recog.simulation.simulation_settings import SpawnSettings, whole_steps


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


class ScheduledSensor:
    """A sensor that is read once in a period, while it is enabled.

    Attributes:
        robot: Name of the body that carries it.
        name: Name of the sensor.
        kind: Name of its kind.
        sensor: Sensor.
        enabled: Whether it is read.
        skipped_from: Step of the physics from which on its readings were not made, while it is
            disabled.
    """

    def __init__(self, robot: str, name: str, kind: str, period_steps: int, sensor: Sensor,
                 noise: np.random.RandomState):
        """period_steps: Steps between two readings. noise: Random generator of the sensor."""
        self.robot, self.name, self.kind, self.sensor = robot, name, kind, sensor
        self.enabled, self.skipped_from = True, 0
        self._period_steps = period_steps
        self._noise, self._state_at_start = noise, noise.get_state()

    def is_due(self, steps: int) -> bool:
        """Return whether it is read after `steps` steps."""
        return steps % self._period_steps == 0

    def next_reading(self, steps: int) -> int:
        """Return the first step after `steps` at which it is read."""
        return steps + self._period_steps - steps % self._period_steps

    def restart_noise(self) -> None:
        """Let the next noise be the first one."""
        self._noise.set_state(self._state_at_start)
        self.sensor.forget_noise()

    def skip_until(self, steps: int) -> None:
        """Let the next noise be the one that it is if all readings up to a step were made."""
        self.sensor.skip_noise(steps // self._period_steps
                               - self.skipped_from // self._period_steps)


class MountedSensors:
    """The sensors of one body.

    Attributes:
        spec: Configuration from which the sensors were made.
        body: Body whose links carry the sensors.
        settings: Settings of all sensors, in which an empty frame is the root link.
        missing: Links that the body does not have, by the names of the sensors that are left out.
        published: Sensors whose readings are messages; the other ones are drawn, and are disabled
            until then.
        enabled: Sensors that are read.
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
        self.published: List[ConfiguredSensor] = []
        for each in spec.sensors:
            self._mount(each, self.settings.sensors[each.name], drive)
        self._find_enabled()
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
            self.body.name, sensor.name, kind.name,
            kind.period_steps(settings, self._world.step_s),
            kind.make(Mount(self.body, self._world, noise, drive, mount, link,
                            sensor.values.get(kind.name + '_noises', ())), settings), noise)
        if kind.is_drawn:
            self._sensors[sensor.name].enabled = False
        else:
            self.published.append(sensor)

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
        self._find_enabled()

    def _find_enabled(self) -> None:
        self.enabled = [each for each in self._sensors.values() if each.enabled]

    def before_step(self, steps: int) -> None:
        """Count the readings that are not made from a step on: the first, or after a reset."""
        if self._steps is None:
            for scheduled in self._sensors.values():
                scheduled.skipped_from = steps
            self._steps = steps

    def due(self, steps: int) -> List[ScheduledSensor]:
        """Return the sensors that are to be read after `steps` steps."""
        self._steps = steps
        return [scheduled for scheduled in self.enabled if scheduled.is_due(steps)]

    def next_event(self, steps: int) -> int:
        """Return the first step after `steps` at which a sensor is read."""
        return min((each.next_reading(steps) for each in self.enabled), default=sys.maxsize)

    @property
    def kinds(self) -> Set[str]:
        """The kinds of sensors that the robot has, also of those that are disabled."""
        return {each.kind for each in self._sensors.values()}

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


class SimulatedModel(ModelBodies):
    """A model of the world with its sensors.

    Attributes:
        sensors: Sensors of each body that has some.
    """

    def __init__(self, name: str, trees: Sequence[Tree], bodies: Sequence[FramedBody]):
        super().__init__(name, trees, bodies)
        self.sensors: List[MountedSensors] = []

    def notify_moved(self, bodies: Sequence[FramedBody]) -> None:
        for mounted in self.sensors:
            if mounted.body in bodies:
                mounted.notify_teleported()


class Robot(SimulatedModel):
    """A model with a drive. The simulator advances the physics.

    Attributes:
        body: Body of the robot.
        mounted: Its sensors.
        drive: Drive, also if the robot has none that is simulated.
        spec: Configuration from which the robot was made.
        settings: Settings of all parts, in which an empty frame is the root link.
        odometry: Settings of the odometry; the defaults for a robot without odometry.
        drives_from: Step of the physics from which on its periods count.
        lift: How far the robot was moved upward, onto what it was in, when it was last placed.
    """

    is_robot = True

    def __init__(self, spec: ConfiguredModel, world: World):
        """Load the robot into PyBullet. `World.add` makes it a part of the world.

        Raises:
            SimulationError: if a setting does not fit the robot or the physics.
        """
        settings = spec.settings
        self.spec, self.drive, self._world = spec, spec.new_drive(), world
        self.body = RobotBody(spec.model, self.drive.motors, settings.spawn,
                              world.physics_client_id)
        super().__init__(self.body.name, [Tree(self.body.name, spec.model)], [self.body])
        self.mounted = MountedSensors(spec, world, self.body, self.drive)
        self.sensors = [self.mounted]
        self.settings = self.mounted.settings
        self.odometry = cast(OdometrySettings,
                             self.settings.sensors.get('odometry') or OdometrySettings())
        self._lift()
        self._drive_steps = whole_steps('drive_period_s', settings.drive.drive_period_s,
                                        world.step_s)
        self.drives_from = 0

    def _lift(self) -> None:
        self.lift = self._world.lift(self.body)

    def command(self, linear_x: float, angular_z: float, linear_y: float = 0.0) -> None:
        """Drive at linear_x m/s and angular_z rad/s until the next command.

        linear_y: to the left in m/s, for a drive that can.
        """
        self.drive.command(linear_x, angular_z, linear_y)

    @property
    def odometry_origin(self) -> Tuple[float, float, float]:
        """Where the odometry is zero: x, y in m and yaw in rad, in the world."""
        if self.odometry.odometry_source == WORLD:
            return 0.0, 0.0, 0.0
        spawn = self.settings.spawn
        return spawn.x_pos, spawn.y_pos, spawn.yaw

    def before_step(self, steps: int) -> None:
        """Update the drive if that is due after `steps` steps of the physics."""
        if (steps - self.drives_from) % self._drive_steps == 0:
            self.drive.update(self.body)

    def next_event(self, steps: int) -> int:
        """Return the first step after `steps` at which the drive is updated."""
        return steps + self._drive_steps - (steps - self.drives_from) % self._drive_steps

    def reset(self) -> None:
        """Move the robot back to its start, at rest and without a command."""
        self.drive.reset()
        super().reset()
        self._lift()

    def set_start(self, spawn: SpawnSettings) -> None:
        """Start from another pose, also after a reset; moves the robot there."""
        self.settings = dataclasses.replace(self.settings, spawn=spawn)
        self.body.spawn = spawn
        self.reset()
        self.mounted.reset()

    def move_to(self, x: float, y: float, yaw: float) -> None:
        """Move the robot to x, y in m and yaw in rad, at rest and without a command.

        It is put at z_pos, as at the start.
        """
        self.drive.reset()
        self.body.place(BodyPose((x, y, self.settings.spawn.z_pos),
                                 rotations.of_yaw(yaw), self.body.pose().joints))
        self.body.stop_wheels()
        self.notify_moved(self.bodies)

    def notify_moved(self, bodies: Sequence[FramedBody]) -> None:
        """Call after the robot was moved from outside; it is lifted onto what it is in."""
        self._lift()
        self.drive.notify_stopped()
        super().notify_moved(bodies)

    def notify_loaded_again(self) -> None:
        self.drive.notify_stopped()
